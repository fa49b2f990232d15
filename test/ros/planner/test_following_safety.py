from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_ros.planner.following import DeflectionCompensation


def part(begin: float, end: float) -> FloatArray:
    return np.array([[begin, 0.0], [end, 0.0]])


def test_commands_lead_by_what_the_motors_give() -> None:
    give = DeflectionCompensation(("a", "b"), 0.03, 3)
    at = 0.0
    for _ in range(10):
        planned = part(at, at + 0.1)
        begun, at = at, at + 0.1 + give.ahead[0] - 0.02
        assert not give.learn(planned, np.array([begun, 0.0]), np.array([at, 0.0]))
    np.testing.assert_allclose(give.ahead, [0.02, 0.0])


def test_commands_never_lead_by_more_than_the_bound() -> None:
    give = DeflectionCompensation(("a", "b"), 0.03, 3)
    problem = give.learn(part(0.0, 0.1), np.zeros(2), np.array([0.06, 0.0]))
    assert "joint 'a' stays 0.040 rad behind" in problem
    np.testing.assert_allclose(give.ahead, [0.03, 0.0])


def test_a_robot_that_does_not_move_ends_the_motion() -> None:
    give = DeflectionCompensation(("a", "b"), 0.03, 3)
    reported = [give.learn(part(0.0, 0.005), np.zeros(2), np.zeros(2)) for _ in range(3)]
    assert reported[:2] == ["", ""]
    assert "not moved in 3 parts" in reported[2]


def test_progress_renews_patience() -> None:
    give = DeflectionCompensation(("a", "b"), 0.03, 2)
    assert not give.learn(part(0.0, 0.001), np.zeros(2), np.zeros(2))
    assert not give.learn(part(0.0, 0.05), np.zeros(2), np.array([0.05, 0.0]))
    assert not give.learn(part(0.0, 0.001), np.zeros(2), np.zeros(2))
