"""Node `controller_adapter`: trajectories to a joint_trajectory_controller of ros2_control."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import rclpy

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.settings import Settings, setting
from shoecal_ros.adapters.action_controller import ActionController
from shoecal_ros.adapters.adapter import Adapter
from shoecal_ros.adapters.controller import Controller
from shoecal_ros.adapters.foreign import foreign
from shoecal_ros.adapters.topic_controller import TopicController
from shoecal_ros.common.codes import Problem
from shoecal_ros.common.conversions import trajectory_to_ros
from shoecal_ros.common.process import run
from shoecal_ros.common.renewal import TIMEOUT_S, Renewal

LOOK_S = 0.05
"""From one look whether the next piece is due to the next."""
ROUNDING_S = 1e-3
"""By which a piece may be longer: messages carry nanoseconds."""
LAST_WORDS_S = 1.0
"""In which the controller gets to hear the last command, and to do it."""


@dataclass(frozen=True)
class ControllerSettings(Settings):
    """Which controller, and how it is spoken to."""

    controller: str = setting(
        "joint_trajectory_controller", "", "name of the controller, before its topic and action"
    )
    interface: str = setting(
        "action",
        "",
        "action (follow_joint_trajectory: it reports when it gives up) or topic (joint_trajectory)",
        choices=("action", "topic"),
    )
    others: str = setting(
        "",
        "",
        "joints that the controller wants in every goal in addition to the planned ones, with "
        "commas between; they are commanded to stay",
    )


class ControllerAdapter(Adapter):
    """Sends trajectories in short goals, each of which replaces the last; see Renewal.

    The planner's are short already, and pass as they are. A goal begins when the controller takes
    it: one that comes earlier or later than the last by some milliseconds shifts set points by as
    much of their way.
    """

    def __init__(self) -> None:
        super().__init__("controller_adapter")
        settings = self.settings(ControllerSettings)
        words = settings.others.replace(",", " ").split()
        self._others = [(name, self.robot.joint(name)) for name in words]
        self._closes = False
        self._controller = self._reach(settings.interface, settings.controller)
        self._renewal: Renewal | None = None
        self._begun_s = 0.0
        self._sent: tuple[JointTrajectory, float] | None = None
        self.wall_timer(LOOK_S, self._renew)

    @property
    def missing(self) -> str:
        """Why the controller's action or topic is not there; empty where it is."""
        return self._controller.missing

    @property
    def trouble(self) -> Problem | None:
        """The controller refuses, gives up or goes on."""
        return self._controller.trouble

    def follow(self, trajectory: JointTrajectory, measured: FloatArray) -> None:
        """Send its start, and go on with the rest; measured (m,) [rad]."""
        if self._closes:
            raise ShoecalError("this adapter ends; start it again")
        whole = self._with_others(trajectory, measured)
        start = measured[[self.robot.joint(name) for name in whole.names]]
        if whole.duration <= TIMEOUT_S + ROUNDING_S:
            # A command to hold, or a piece of the planner's.
            self._renewal = None
            self._send(whole)
            return
        self._renewal, self._begun_s = Renewal(whole.begun_at(start)), self.now_s
        self._send(self._renewal.piece(0.0))

    def commanded(self, names: tuple[str, ...]) -> FloatArray | None:
        """(k,) on the last piece that was sent [rad]."""
        if self._sent is None or not set(names) <= set(self._sent[0].names):
            return None
        piece, sent_s = self._sent
        angles: FloatArray = piece.at(np.array(self.now_s - sent_s))
        return angles[[piece.names.index(name) for name in names]]

    def stop(self) -> None:
        """Send no more, and cancel the goal where there is one."""
        self._renewal = None
        self._controller.stop()

    def watch(self) -> None:
        """See to it that the controller does what it was commanded, too."""
        self._controller.watch()
        super().watch()

    def close(self) -> None:
        """Leave no robot on its way: what ends at once takes its last command with it."""
        super().close()
        self._closes = True
        end = self.now_s + LAST_WORDS_S
        while self.context.ok() and self._controller.busy and self.now_s < end:
            rclpy.spin_once(self, timeout_sec=0.1)
            self._controller.watch()

    def _reach(self, interface: str, name: str) -> Controller:
        if interface == "topic":
            return TopicController(self, name)
        kind = foreign("control_msgs", "action", "FollowJointTrajectory")
        return ActionController(self, kind, name, self._give_up)

    def _give_up(self) -> None:
        """The controller refused a goal: it comes to rest at the end of the one before."""
        self._renewal = None

    def _renew(self) -> None:
        """Send the next goal while the robot may move."""
        elapsed, renewal = self.now_s - self._begun_s, self._renewal
        if renewal is None or not renewal.due(elapsed):
            return
        if elapsed - renewal.begun > renewal.timeout_s or self.joints.problem:
            # It has come to rest meanwhile, and may have been moved.
            self._renewal = None
        else:
            self._send(renewal.piece(elapsed))

    def _send(self, piece: JointTrajectory) -> None:
        self._sent = piece, self.now_s
        self._controller.send(trajectory_to_ros(piece))

    def _with_others(self, trajectory: JointTrajectory, measured: FloatArray) -> JointTrajectory:
        added = [(name, joint) for name, joint in self._others if name not in trajectory.names]
        still = np.tile([measured[joint] for _, joint in added], (len(trajectory.times), 1))
        still = still.reshape(len(trajectory.times), -1)
        velocities = trajectory.velocities
        return JointTrajectory(
            (*trajectory.names, *(name for name, _ in added)),
            trajectory.times,
            np.hstack([trajectory.positions, still]),
            None if velocities is None else np.hstack([velocities, np.zeros_like(still)]),
        )


def main() -> None:
    """Run the node."""
    run(ControllerAdapter)


if __name__ == "__main__":
    main()
