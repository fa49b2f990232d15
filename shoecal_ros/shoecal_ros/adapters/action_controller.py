"""A controller that takes trajectories as goals of its action, and reports how they end."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.node import Node
from rclpy.task import Future
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_ros.adapters.controller import Controller, absent
from shoecal_ros.adapters.goal import PATIENCE_S, Goal
from shoecal_ros.common.codes import Code, Problem


class ActionController(Controller):
    """It holds by itself when it is cancelled."""

    def __init__(self, node: Node, kind: Any, name: str, goes_on: Callable[[], None]) -> None:
        """Nothing is under way.

        Args:
            node: that speaks to it.
            kind: control_msgs/action/FollowJointTrajectory.
            name: of the controller.
            goes_on: called where it refuses a trajectory: it goes on with the one before.
        """
        self._kind = kind
        self._name = name
        self._action = node.resolve_topic_name(f"{name}/follow_joint_trajectory")
        self._client = ActionClient(node, self._kind, self._action)
        self._goes_on = goes_on
        self._newest = 0
        self._unanswered = 0
        self._stopped_s = math.inf
        self._goals: list[Goal] = []
        self._refusal: Problem | None = None

    @property
    def missing(self) -> str:
        """Why the action is not offered; empty where it is."""
        return "" if self._client.server_is_ready() else absent(self._action)

    @property
    def trouble(self) -> Problem | None:
        """It goes on with what it should end, refuses or gives up."""
        if any(goal.overdue for goal in self._goals):
            return Problem(
                Code.CONTROLLER_GOES_ON,
                f"{self._name} was asked to stop and goes on; use the robot's emergency stop, or "
                "stop the controller",
            )
        return self._refusal

    def send(self, message: JointTrajectoryMsg) -> None:
        """Send a goal; it ends the one before."""
        self._refusal, self._stopped_s = None, math.inf
        self._newest += 1
        number = self._newest
        sent = self._client.send_goal_async(self._kind.Goal(trajectory=message))
        self._unanswered += 1
        sent.add_done_callback(lambda future: self._answered(number, future))

    def stop(self) -> None:
        """Cancel the goal."""
        # One that is still on its way there is cancelled when it has been accepted.
        self._newest += 1
        self._stopped_s = time.monotonic()
        for goal in self._goals:
            goal.cancel()
        self.watch()

    def watch(self) -> None:
        """Cancel again what has not ended."""
        now = time.monotonic()
        if self._client.server_is_ready():
            if self._unanswered and now - self._stopped_s > PATIENCE_S:
                # Accepted or not: the answer may be lost.
                self._unanswered, self._stopped_s = 0, math.inf
            for goal in self._goals:
                goal.watch()
        self._goals = [goal for goal in self._goals if not goal.ended]

    @property
    def busy(self) -> bool:
        """Whether a goal has not been answered to, or is to end."""
        return self._unanswered > 0 or any(goal.ending for goal in self._goals)

    def _answered(self, number: int, future: Future) -> None:
        self._unanswered = max(0, self._unanswered - 1)
        handle: ClientGoalHandle = future.result()
        if not handle.accepted:
            self._goes_on()
            self._refusal = Problem(
                Code.CONTROLLER_REFUSED,
                f"{self._name} refused the trajectory; see its log (it may want more joints: "
                "'others')",
            )
            return
        goal = Goal(handle)
        self._goals.append(goal)
        handle.get_result_async().add_done_callback(lambda done: self._ended(number, goal, done))
        if number != self._newest:
            goal.cancel()
            self.watch()

    def _ended(self, number: int, goal: Goal, future: Future) -> None:
        goal.end()
        result = future.result().result
        if number == self._newest and result.error_code != self._kind.Result.SUCCESSFUL:
            self._refusal = Problem(
                Code.CONTROLLER_GAVE_UP,
                f"{self._name} gave up with code {result.error_code}: "
                f"{result.error_string or 'no reason reported'}; see its log",
            )
