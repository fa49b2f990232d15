from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.adapters.renewal import GOAL_S, PERIOD_S, Renewal

NAMES = ("hip", "knee")
START = np.array([0.1, 0.2])


def trajectory(duration: float, first: float = 0.0) -> JointTrajectory:
    times = np.linspace(first, duration, 51)
    return JointTrajectory(NAMES, times, np.column_stack([times, 1.0 - times]))


def test_no_goal_is_longer_than_half_a_second() -> None:
    renewal, now = Renewal(trajectory(3.0), START, 100.0), 100.0
    while not renewal.done:
        goal = renewal.goal(now)
        assert goal.times[0] > 0.0
        assert goal.duration <= GOAL_S + 1e-9
        # It is the trajectory, from this moment on.
        np.testing.assert_allclose(goal.positions[:, 0], now - 100.0 + goal.times, atol=1e-6)
        np.testing.assert_allclose(goal.positions[:, 1], 1.0 - goal.positions[:, 0], atol=1e-6)
        now += PERIOD_S
    np.testing.assert_allclose(goal.positions[-1], [3.0, -2.0])


def test_it_begins_where_the_joints_are() -> None:
    goal = Renewal(JointTrajectory(NAMES, np.array([1.0]), np.ones((1, 2))), START, 0.0).goal(0.0)
    np.testing.assert_allclose(goal.positions[-1], (START + 1.0) / 2.0)


def test_a_short_one_is_sent_whole() -> None:
    renewal = Renewal(trajectory(0.3), START, 0.0)
    assert renewal.goal(0.0).duration == pytest.approx(0.3)
    assert renewal.done


def test_who_comes_late_goes_on_from_the_end_of_the_goal_before() -> None:
    renewal = Renewal(trajectory(10.0), START, 0.0)
    before = renewal.goal(0.0)
    after = renewal.goal(5.0)
    assert after.positions[0, 0] - before.positions[-1, 0] < 0.03
    assert after.positions[-1, 0] == pytest.approx(2.0 * GOAL_S)
    assert renewal.goal(5.0 + PERIOD_S).positions[-1, 0] == pytest.approx(2.0 * GOAL_S + PERIOD_S)


def test_a_point_at_once_is_allowed() -> None:
    once = JointTrajectory(NAMES, np.array([0.0]), np.ones((1, 2)))
    goal = Renewal(once, START, 0.0).goal(0.0)
    assert goal.times[0] > 0.0
    np.testing.assert_allclose(goal.positions[-1], 1.0)
