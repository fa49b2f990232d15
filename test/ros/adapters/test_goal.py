"""Whether a controller that is told to end everything has done so."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from action_msgs.msg import GoalStatus, GoalStatusArray
from action_msgs.srv import CancelGoal
from rclpy.task import Future

from ros.clock import Clock
from shoecal_ros.adapters.goal import PATIENCE_S, UNSURE_S, AllGoals


class Listener:
    """In place of a node: who is there is told by the test."""

    def __init__(self) -> None:
        self.there: list[bytes] = []
        self.receive: Callable[[GoalStatusArray], None]

    def create_subscription(self, _kind: Any, _topic: str, receive: Any, _profile: Any) -> None:
        self.receive = receive

    def get_publishers_info_by_topic(self, _topic: str) -> list[SimpleNamespace]:
        return [SimpleNamespace(endpoint_gid=list(gid)) for gid in self.there]


GOES_ON = GoalStatusArray(status_list=[GoalStatus(status=GoalStatus.STATUS_EXECUTING)])


def all_goals(node: Listener) -> AllGoals:
    return AllGoals(node, None, "legs")  # type: ignore[arg-type]  # all that is asked of a node


def answered(goals: AllGoals) -> None:
    """The controller has answered that there is nothing to cancel."""
    done: Future = Future()
    done.set_result(CancelGoal.Response())
    goals._answered(done)


def test_what_was_heard_before_its_teller_was_there_is_nothing_of_the_next_one() -> None:
    node = Listener()
    goals = all_goals(node)
    node.receive(GOES_ON)
    # As where the controller's services are not found yet.
    goals.forget()
    node.there = [b"first"]
    goals.watch()
    goals.cancel()
    answered(goals)
    assert goals.ending
    node.there = [b"second"]
    answered(goals)
    assert not goals.ending


def test_what_a_controller_told_may_come_later_than_its_answer() -> None:
    """Some refuse to cancel without saying so."""
    node = Listener()
    node.there = [b"one"]
    goals = all_goals(node)
    goals.cancel()
    answered(goals)
    assert not goals.ending
    node.receive(GOES_ON)
    assert goals.ending
    answered(goals)
    assert goals.ending
    node.receive(GoalStatusArray())
    answered(goals)
    assert not goals.ending
    node.receive(GOES_ON)
    assert not goals.ending, "that is a later one"


def test_what_comes_long_after_the_answer_is_a_later_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """A controller that never had a goal tells nothing until it gets one."""
    clock = Clock()
    monkeypatch.setattr("shoecal_ros.adapters.goal.time.monotonic", clock)
    node = Listener()
    node.there = [b"one"]
    goals = all_goals(node)
    goals.cancel()
    answered(goals)
    clock.now += UNSURE_S + 0.1
    node.receive(GOES_ON)
    assert not goals.ending
    assert not goals.overdue


def test_what_was_heard_late_is_given_its_time_to_end(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock()
    monkeypatch.setattr("shoecal_ros.adapters.goal.time.monotonic", clock)
    node = Listener()
    node.there = [b"one"]
    goals = all_goals(node)
    goals.cancel()
    answered(goals)
    clock.now += UNSURE_S - 0.1
    node.receive(GOES_ON)
    assert goals.ending
    assert not goals.overdue
    clock.now += PATIENCE_S + 0.1
    assert goals.overdue


def test_what_was_sent_since_is_not_taken_for_what_was_to_end() -> None:
    node = Listener()
    node.there = [b"one"]
    goals = all_goals(node)
    goals.cancel()
    answered(goals)
    goals.give_way()
    node.receive(GOES_ON)
    assert not goals.ending
