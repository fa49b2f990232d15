"""Goals of a controller that are to end."""

from __future__ import annotations

import math
import time

from action_msgs.msg import GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.node import Node
from rclpy.qos import qos_profile_action_status_default
from rclpy.task import Future

AGAIN_S = 0.5
"""A goal that has not been heard to end is cancelled again after so long."""
PATIENCE_S = 1.0
"""In which a goal that was asked to end should have ended."""
UNSURE_S = 3.0
"""The state of a controller's goals comes within so long, or is that of later ones."""
_ENDED = (GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED)


class Goal:
    """A goal that was accepted, until the controller has said that it ended.

    Requests and answers may be lost, and a controller may refuse to cancel: it is asked until it
    does.
    """

    def __init__(self, handle: ClientGoalHandle) -> None:
        """It is under way; by its handle it is asked for."""
        self._handle = handle
        self._ended = False
        self._canceled_s = math.inf
        self._asked_s = -math.inf

    @property
    def ended(self) -> bool:
        """Whether it has."""
        return self._ended or self._handle.status in _ENDED

    @property
    def ending(self) -> bool:
        """Whether it is to end, and has not."""
        return self._canceled_s < math.inf and not self.ended

    @property
    def overdue(self) -> bool:
        """Whether it should have ended by now."""
        return self.ending and time.monotonic() - self._canceled_s > PATIENCE_S

    def end(self) -> None:
        """The controller reported how it ended."""
        self._ended = True

    def cancel(self) -> None:
        """It is to end: `watch` asks for that."""
        self._canceled_s = min(self._canceled_s, time.monotonic())

    def watch(self) -> None:
        """Ask where that is due; to be called again and again while the controller is there."""
        now = time.monotonic()
        if self.ending and now - self._asked_s >= AGAIN_S:
            self._asked_s = now
            self._handle.cancel_goal_async().add_done_callback(self._answered)

    def judge(self, answer: CancelGoal.Response) -> bool:
        """Whether an answer says that it has ended."""
        if answer.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED:
            # So it is said as well of one that is about to.
            return bool(self._handle.status != GoalStatus.STATUS_CANCELING)
        return bool(answer.return_code == CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID)

    def _answered(self, future: Future) -> None:
        self._ended = self._ended or self.judge(future.result())


class AllGoals(Goal):
    """All goals of a controller, by any sender: what the controller reports of them counts.

    They have ended once it has answered, and reports none that goes on; then others may come, and
    may be cancelled again. One that never had a goal reports nothing at all; what another one
    reported may come a little later than its answer, and counts all the same.
    """

    def __init__(self, node: Node, client: ActionClient, action: str) -> None:
        """They may go on.

        Args:
            node: that listens to what the controller reports.
            client: of its action.
            action: its name.
        """
        # An id of zeros stands for every goal; nothing asks how that was answered.
        every = CancelGoal.Request().goal_info.goal_id
        super().__init__(ClientGoalHandle(client, every, None))
        self._node, self._topic = node, f"{action}/_action/status"
        self._reported = self._going_on = False
        self._unsure_until_s = -math.inf
        self._publishers: frozenset[bytes] = frozenset()
        node.create_subscription(
            GoalStatusArray, self._topic, self._hear, qos_profile_action_status_default
        )

    def cancel(self) -> None:
        """Those of this moment are to end."""
        if self._ended:
            self.forget()
        super().cancel()

    def forget(self) -> None:
        """They may go on."""
        self._ended, self._canceled_s, self._asked_s = False, math.inf, -math.inf
        self._unsure_until_s = -math.inf

    def give_way(self) -> None:
        """Another goal is sent: what the controller reports from now on may be of that."""
        self._unsure_until_s = -math.inf

    def watch(self) -> None:
        """Ask where that is due, and see who is there."""
        if self._reported and not self._publishers:
            # It was heard before it was known that anybody is there.
            self._publishers = self._publishers_now()
        super().watch()

    def judge(self, answer: CancelGoal.Response) -> bool:
        """Whether nothing goes on: some refuse without saying so."""
        refused = answer.return_code == CancelGoal.Response.ERROR_REJECTED
        if refused or answer.goals_canceling:
            return False
        gone = self._publishers and self._publishers.isdisjoint(self._publishers_now())
        if self._reported and not gone:
            return not self._going_on
        self._unsure_until_s = time.monotonic() + UNSURE_S
        return True

    def _publishers_now(self) -> frozenset[bytes]:
        infos = self._node.get_publishers_info_by_topic(self._topic)
        return frozenset(bytes(info.endpoint_gid) for info in infos)

    def _hear(self, reported: GoalStatusArray) -> None:
        self._reported = True
        self._going_on = any(one.status not in _ENDED for one in reported.status_list)
        self._publishers = self._publishers_now()
        if self._going_on and time.monotonic() <= self._unsure_until_s:
            self._ended, self._canceled_s = False, time.monotonic()
        self._unsure_until_s = -math.inf
