"""Node `controller_adapter`: trajectories to a joint_trajectory_controller of ros2_control."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
import rclpy
from rclpy.action import ActionClient
from rclpy.duration import Duration
from rclpy.task import Future
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_core.errors import ShoecalError
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_core.settings import Settings, setting
from shoecal_ros.adapters.adapter import Adapter, FloatArray
from shoecal_ros.adapters.foreign import foreign
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.conversions import trajectory_to_ros
from shoecal_ros.common.hold import STOP_TIME_S, hold
from shoecal_ros.common.process import run

LATE_S = 1.0
"""For so long after its time a motion may go on: a topic does not tell when it has ended."""
LAST_WORDS_S = 1.0
"""In which the controller gets to hear the last command."""


@dataclass(frozen=True)
class ControllerSettings(Settings):
    """Which controller, and how it is spoken to."""

    controller: str = setting(
        "joint_trajectory_controller", "", "name of the controller, before its topic and action"
    )
    interface: str = setting(
        "action",
        "",
        "action (follow_joint_trajectory: it tells when it gives up) or topic (joint_trajectory)",
        choices=("action", "topic"),
    )
    others: str = setting(
        "",
        "",
        "joints that the controller wants in every goal beside the planned ones, with commas "
        "between; they are told to stay",
    )


class ControllerAdapter(Adapter):
    """One goal at a time: the controller itself lets a new one replace the last."""

    def __init__(self) -> None:
        super().__init__("controller_adapter")
        self._settings = self.settings(ControllerSettings)
        words = self._settings.others.replace(",", " ").split()
        self._others = [(name, self.robot.joint(name)) for name in words]
        self._until_s = 0.0
        self._goal: Any = None
        self._newest = 0
        self._unanswered = 0
        self._closes = False
        name = self._settings.controller
        self._client: ActionClient | None = None
        if self._settings.interface == "action":
            self._kind = foreign("control_msgs", "action", "FollowJointTrajectory")
            self._client = ActionClient(self, self._kind, f"{name}/follow_joint_trajectory")
        else:
            self._publisher = self.create_publisher(
                JointTrajectoryMsg, f"{name}/joint_trajectory", qos.COMMAND
            )

    def follow(self, trajectory: JointTrajectory, measured: FloatArray) -> None:
        """Send the whole of it."""
        if self._closes:
            raise ShoecalError("this adapter ends; start it again")
        message = trajectory_to_ros(self._with_others(trajectory, measured))
        if self._client is None:
            if self._publisher.get_subscription_count() == 0:
                raise ShoecalError(self._absent(self._publisher.topic_name))
            self._publisher.publish(message)
        else:
            if not self._client.server_is_ready():
                raise ShoecalError(self._absent(f"{self._settings.controller}'s action"))
            self._newest += 1
            number = self._newest
            sent = self._client.send_goal_async(self._kind.Goal(trajectory=message))
            self._unanswered += 1
            sent.add_done_callback(lambda future: self._accepted(number, future))
        self.trouble = None
        self._until_s = self.now_s + trajectory.duration + LATE_S

    def stop(self) -> None:
        """Cancel the goal, or hold: a controller that is cancelled holds by itself."""
        if self._client is not None:
            # A goal that is still on its way there is cancelled when it has been accepted.
            self._newest += 1
            if self._goal is not None:
                self._cancel(self._goal)
                self._goal = None
        elif self.joints.latest is not None and self.now_s < self._until_s:
            self._until_s = self.now_s
            measured = self.joints.latest.angles[0]
            # Back to where they were when last told, no faster than they went on meanwhile.
            command = hold(self.robot, measured, STOP_TIME_S + self.joints.age_s)
            self._publisher.publish(trajectory_to_ros(self._with_others(command, measured)))

    def close(self) -> None:
        """Leave no robot on its way: what ends at once takes its last command with it."""
        super().close()
        self._closes = True
        end = self.now_s + LAST_WORDS_S
        if self._client is None and self.context.ok():
            self._publisher.wait_for_all_acked(Duration(seconds=LAST_WORDS_S))
        while self._unanswered and self.context.ok() and self.now_s < end:
            rclpy.spin_once(self, timeout_sec=0.1)

    def _with_others(self, trajectory: JointTrajectory, measured: FloatArray) -> JointTrajectory:
        added = [(name, joint) for name, joint in self._others if name not in trajectory.names]
        still = np.tile([measured[joint] for _, joint in added], (len(trajectory.times), 1))
        return JointTrajectory(
            (*trajectory.names, *(name for name, _ in added)),
            trajectory.times,
            np.hstack([trajectory.positions, still.reshape(len(trajectory.times), -1)]),
        )

    def _absent(self, what: str) -> str:
        return f"nobody offers {what}; start the controller, or correct 'controller'"

    def _cancel(self, goal: Any) -> None:
        self._unanswered += 1
        goal.cancel_goal_async().add_done_callback(self._canceled)

    def _canceled(self, _: Future) -> None:
        self._unanswered -= 1

    def _accepted(self, number: int, future: Future) -> None:
        self._unanswered -= 1
        goal = future.result()
        if not goal.accepted:
            self._moves = True  # the one before goes on
            self.trouble = Problem(
                Code.CONTROLLER_REFUSED,
                f"{self._settings.controller} refused the trajectory; see its log (it may want "
                "more joints: 'others')",
            )
            return
        if number != self._newest:
            self._cancel(goal)
            return
        self._goal = goal
        goal.get_result_async().add_done_callback(lambda done: self._ended(number, goal, done))

    def _ended(self, number: int, goal: Any, future: Future) -> None:
        result = future.result().result
        if self._goal is goal:
            self._goal = None
        if number != self._newest:
            return
        if result.error_code != self._kind.Result.SUCCESSFUL:
            self.trouble = Problem(
                Code.CONTROLLER_GAVE_UP,
                f"{self._settings.controller} gave up with code {result.error_code}: "
                f"{result.error_string or 'no reason told'}",
            )


def main() -> None:
    """Run the node."""
    sys.exit(run(ControllerAdapter))


if __name__ == "__main__":
    main()
