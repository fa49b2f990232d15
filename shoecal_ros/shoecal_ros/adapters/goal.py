"""Goals of a controller that are to end."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from action_msgs.msg import GoalStatus
from action_msgs.srv import CancelGoal
from rclpy.action import ActionClient
from rclpy.action.client import ClientGoalHandle
from rclpy.task import Future

AGAIN_S = 0.5
"""Whoever has not been heard to end is asked again after so long."""
PATIENCE_S = 1.0
"""In which a goal that was asked to end should have ended."""
_ENDED = (GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED)


class Goal:
    """A goal that was accepted, until the controller has said that it ended.

    Requests and answers may be lost, and a controller may refuse to cancel: it is asked until it
    does.
    """

    def __init__(
        self, handle: ClientGoalHandle, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """It is under way.

        Args:
            handle: by which it is asked for.
            clock: monotonic [s].
        """
        self._handle = handle
        self._clock = clock
        self._ended = False
        self._canceled_s = math.inf
        self._asked_s = -math.inf
        self._unanswered = False

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
        return not self.ended and self._clock() - self._canceled_s > PATIENCE_S

    @property
    def unanswered(self) -> bool:
        """Whether it was asked to end, and nothing was said to that."""
        return self._unanswered

    def end(self) -> None:
        """The controller told how it ended."""
        self._ended = True

    def cancel(self) -> None:
        """It is to end: `watch` asks for that."""
        self._canceled_s = min(self._canceled_s, self._clock())

    def watch(self) -> None:
        """Ask where that is due; to be called again and again while the controller is there."""
        # A controller that is about to end it needs not be asked.
        if not self.ending or self._handle.status == GoalStatus.STATUS_CANCELING:
            return
        now = self._clock()
        if now - self._asked_s >= AGAIN_S:
            self._asked_s, self._unanswered = now, True
            self._handle.cancel_goal_async().add_done_callback(self._answered)

    def judge(self, answer: CancelGoal.Response) -> bool:
        """Whether an answer says that it has ended."""
        if answer.return_code == CancelGoal.Response.ERROR_GOAL_TERMINATED:
            # So it is said as well of one that is about to.
            return bool(self._handle.status != GoalStatus.STATUS_CANCELING)
        return bool(answer.return_code == CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID)

    def _answered(self, future: Future) -> None:
        self._unanswered = False
        self._ended = self._ended or self.judge(future.result())


class Everything(Goal):
    """All goals that a controller has, whoever sent them: ended once it agrees to cancel them."""

    def __init__(
        self, client: ActionClient, kind: Any, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """They are to end.

        Args:
            client: of the controller's action.
            kind: of that action.
            clock: monotonic [s].
        """
        # An id of zeros stands for every goal.
        every = kind.Impl.SendGoalService.Request().goal_id
        accepted = kind.Impl.SendGoalService.Response(accepted=True)
        super().__init__(ClientGoalHandle(client, every, accepted), clock)
        self.cancel()

    def judge(self, answer: CancelGoal.Response) -> bool:
        """Whether the controller did not refuse."""
        return bool(answer.return_code != CancelGoal.Response.ERROR_REJECTED)
