"""Who wants the robot to move, and with what."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_ros.common.awake_clock import AwakeClock
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.worker import Worker
from shoecal_ros.inputs.joints import JointInput
from shoecal_ros.inputs.robot_time import RobotTime
from shoecal_ros.planner.arming import Arming
from shoecal_ros.planner.listeners import Listeners
from shoecal_ros.planner.settings import MovingSettings
from shoecal_ros.planner.watch import Senses


class Mover(Protocol):
    """What moving the robot needs of its node."""

    robot: Robot
    kinematics: Kinematics
    files: RobotFiles
    planning: PlannerSettings
    moving: MovingSettings
    joints: JointInput
    listeners: Listeners
    senses: Senses
    arming: Arming
    worker: Worker
    robot_time: RobotTime
    awake: AwakeClock

    def command(
        self, trajectory: JointTrajectory, stamp_ns: int = 0, not_after: float = math.inf
    ) -> bool:
        """Send a trajectory to the robot that begins at a stamp [ns]; zero: on receipt.

        Returns:
            Whether it was sent: not after a time by the monotonic clock [s].
        """


@dataclass(frozen=True)
class Order:
    """Who wants the robot to move.

    Attributes:
        sends: whether anything is to be sent to the robot.
        is_canceled: whether they want it no more.
        feed: takes the phase (planning, moving), progress 0 to 1, and the landmark pursued.
    """

    sends: bool
    is_canceled: Callable[[], bool]
    feed: Callable[[str, float, int], None]
