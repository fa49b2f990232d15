"""Actions, from both sides."""

from __future__ import annotations

import math
import time
from collections.abc import Awaitable, Callable
from typing import Any, TypeVar

from rclpy.action import ActionClient
from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future

from shoecal_core.errors import ShoecalError
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.waiting import until

R = TypeVar("R", bound=Any)

ANSWER_S = 10.0
"""Wall-clock time in which a server must answer a request, or end what it was asked to stop."""


FEEDBACK_S = 0.2
"""Wall-clock time from feedback to feedback of the same stage."""


class ActionError(ShoecalError):
    """An action whose server does not do its part."""


class NotSentError(ShoecalError):
    """A goal that was not wanted any more before it could be sent."""


class Pacing:
    """Keeps feedback lean: another stage is sent at once, the same one again after a while."""

    def __init__(self) -> None:
        self._reported = ("", -math.inf)

    def due(self, stage: str) -> bool:
        """Whether to send now; counts as sent then."""
        reported, at = self._reported
        now = time.monotonic()
        if stage == reported and now - at < FEEDBACK_S:
            return False
        self._reported = (stage, now)
        return True


async def answered(goal: ServerGoalHandle, result: R, do: Callable[[], Awaitable[str]]) -> R:
    """Do what a goal asks for; how that ended, in its result and its state.

    Args:
        goal: of an action.
        result: with `success`, `message`, `error_code` and the code CANCELED.
        do: what came out, for a person; a RefusedError ends it otherwise.
    """
    try:
        result.message = await do()
        result.success = True
        goal.succeed()
    except RefusedError as refusal:
        result.error_code, result.message = refusal.code, str(refusal)
        if refusal.code == result.CANCELED and goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
    return result


async def do_action(
    client: ActionClient,
    name: str,
    goal: Any,
    *,
    feedback: Callable[[Any], None],
    stop: Callable[[], bool],
    timeout_s: float,
) -> Any:
    """Have a goal done; its result, successful or not.

    Args:
        client: of the action.
        name: of the action, for messages.
        goal: to send.
        feedback: takes what the server reports meanwhile.
        stop: whether to cancel the goal; the result then says how it ended.
        timeout_s: longest wall-clock time.

    Raises:
        NotSentError: when it was to stop before it began.
        ActionError: when the server is not there, vanishes, refuses or takes too long.
    """
    ready = await until(lambda: client.server_is_ready() or stop(), ANSWER_S)
    if stop():
        raise NotSentError(f"the action {name} was stopped before it began")
    if not ready:
        raise ActionError(f"no node offers the action {name}; start the node that does")
    sent = client.send_goal_async(goal, lambda message: feedback(message.feedback))
    if not await until(sent.done, ANSWER_S):
        # Accepted after all, it would never be ended.
        sent.add_done_callback(_cancel_late)
        raise ActionError(f"the action {name} does not answer; restart the node that offers it")
    handle = sent.result()
    if not handle.accepted:
        raise ActionError(f"the action {name} does not accept the goal; see its node's log")
    result = handle.get_result_async()
    deadline = time.monotonic() + timeout_s
    await until(lambda: result.done() or stop() or not client.server_is_ready(), timeout_s)
    if not result.done():
        if not client.server_is_ready():
            raise ActionError(f"the node that offers the action {name} is gone; start it again")
        handle.cancel_goal_async()
        if not await until(result.done, ANSWER_S):
            raise ActionError(f"the action {name} does not end when cancelled; stop its node")
        if time.monotonic() >= deadline and not stop():
            raise ActionError(
                f"the action {name} took longer than {timeout_s:g} s and was cancelled; "
                "see what its node waits for, or raise the time-out"
            )
    return result.result().result


def _cancel_late(sent: Future) -> None:
    if sent.exception() is None and sent.result().accepted:
        sent.result().cancel_goal_async()
