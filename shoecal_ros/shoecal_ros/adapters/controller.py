"""A joint_trajectory_controller of ros2_control, however it is spoken to."""

from __future__ import annotations

from abc import ABC, abstractmethod

from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_ros.common.codes import Problem

FOUND_S = 3.0
"""In which a node that has just begun finds who is there."""


class Controller(ABC):
    """One trajectory at a time: a new one takes the place of the last."""

    @property
    @abstractmethod
    def missing(self) -> str:
        """What is not offered, and the cure; empty where it is."""

    @property
    def trouble(self) -> Problem | None:
        """What the controller does that it should not."""
        return None

    @abstractmethod
    def send(self, message: JointTrajectoryMsg) -> None:
        """Let the robot follow a trajectory."""

    @abstractmethod
    def stop(self) -> None:
        """Let the robot stay where it is, if it is on its way."""

    @abstractmethod
    def watch(self) -> None:
        """Do what is left to be done; to be called again and again."""

    @property
    @abstractmethod
    def busy(self) -> bool:
        """Whether a command has not come there, or is not done."""


def absent(name: str) -> str:
    """Message that a topic or an action is not offered."""
    return f"no node offers {name}; start the controller, or correct 'controller'"
