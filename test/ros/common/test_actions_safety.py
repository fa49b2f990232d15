from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Any, cast

import pytest
from rclpy.action import ActionClient
from rclpy.task import Future

from shoecal_ros.common import actions
from shoecal_ros.common.actions import ActionError, NotSentError, do_action


class Handle:
    accepted = True
    canceled = False

    def cancel_goal_async(self) -> None:
        self.canceled = True


class Client:
    """The client's side of a server that never answers by itself."""

    def __init__(self) -> None:
        self.sent: list[object] = []
        self.answer = Future()

    def server_is_ready(self) -> bool:
        return True

    def send_goal_async(self, goal: object, _: Callable[[Any], None]) -> Future:
        self.sent.append(goal)
        return self.answer


def ended(work: Coroutine[Any, Any, Any]) -> None:
    """Run to what it raises."""
    while True:
        work.send(None)


def doing(client: Client, stop: Callable[[], bool]) -> Coroutine[Any, Any, Any]:
    return do_action(
        cast(ActionClient, client), "robot/go", "goal",
        feedback=lambda _: None, stop=stop, timeout_s=1.0,
    )  # fmt: skip


def test_a_goal_that_is_not_wanted_any_more_is_not_sent() -> None:
    client = Client()
    with pytest.raises(NotSentError, match="robot/go"):
        ended(doing(client, lambda: True))
    assert not client.sent


def test_a_goal_accepted_too_late_is_cancelled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(actions, "ANSWER_S", 0.0)
    client, handle = Client(), Handle()
    with pytest.raises(ActionError, match="robot/go does not answer"):
        ended(doing(client, lambda: False))
    client.answer.set_result(handle)
    assert handle.canceled
