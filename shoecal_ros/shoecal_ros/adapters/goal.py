"""Goals of a controller that are to end."""

from __future__ import annotations

import math
import time

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action.client import ClientGoalHandle
from rclpy.task import Future

AGAIN_S = 0.5
"""A goal that has not been heard to end is cancelled again after so long."""
PATIENCE_S = 1.0
"""In which a goal that was asked to end should have ended."""
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

    def _judge(self, answer: CancelGoal.Response) -> bool:
        """Whether an answer says that it has ended."""
        if answer.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED:
            # So it is said as well of one that is about to.
            return bool(self._handle.status != GoalStatus.STATUS_CANCELING)
        return bool(answer.return_code == CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID)

    def _answered(self, future: Future) -> None:
        self._ended = self._ended or self._judge(future.result())
