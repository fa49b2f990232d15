"""Ends of actions, on both sides."""

from __future__ import annotations

from typing import Any

from rclpy.action.server import ServerGoalHandle


def finish(goal: ServerGoalHandle, result: Any, *, canceled: int) -> None:
    """Bring a goal into the state that its result tells.

    Args:
        goal: that has been worked on.
        result: with `success` and `error_code`.
        canceled: the code for cancelled.
    """
    if result.success:
        goal.succeed()
    elif result.error_code == canceled and goal.is_cancel_requested:
        goal.canceled()
    else:
        goal.abort()
