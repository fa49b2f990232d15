from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_ros.planner.following import Follower, Verdict

START_NS = 5_000_000_000
TRAJECTORY = JointTrajectory(
    ("a", "b"),
    np.linspace(0.0, 4.0, 41),
    np.column_stack([0.1 * np.linspace(0.0, 4.0, 41), np.full(41, -0.5)]),
)


def follower() -> Follower:
    return Follower(TRAJECTORY, START_NS, error_bound=0.05, late_s=0.5)


def at(time: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.asarray(TRAJECTORY.at(np.array(time)))


@given(st.floats(0.0, 4.4), st.floats(0.0, 0.5))
def test_a_late_robot_follows(time: float, late: float) -> None:
    look = follower().look(START_NS + round(time * 1e9), at(time - late))
    assert look.verdict is Verdict.FOLLOWS
    assert look.error < 0.01


@given(st.floats(0.0, 6.0), st.sampled_from([0, 1]), st.sampled_from([-1, 1]))
def test_a_joint_far_off_is_lost_and_named(time: float, joint: int, side: int) -> None:
    angles = at(time).copy()
    angles[joint] += side * 0.2
    look = follower().look(START_NS + round(time * 1e9), angles)
    assert look.verdict is Verdict.LOST
    assert look.joint == TRAJECTORY.names[joint]


def test_a_robot_that_never_starts_is_lost() -> None:
    verdicts = [
        follower().look(START_NS + round(time * 1e9), at(0.0)).verdict
        for time in np.arange(0.0, 3.0, 0.1)
    ]
    assert verdicts[0] is Verdict.FOLLOWS
    assert verdicts[-1] is Verdict.LOST


def test_it_has_arrived_when_even_a_late_robot_must_have() -> None:
    assert follower().look(START_NS + 4_400_000_000, at(4.0)).verdict is Verdict.FOLLOWS
    look = follower().look(START_NS + 4_600_000_000, at(4.0))
    assert look.verdict is Verdict.ARRIVED
    assert look.progress == pytest.approx(1.0)


def test_a_robot_that_stopped_on_the_way_has_not_arrived() -> None:
    assert follower().look(START_NS + 9_000_000_000, at(2.0)).verdict is Verdict.LOST


def test_a_joint_that_tells_nothing_does_not_count() -> None:
    angles = at(1.0).copy()
    angles[1] = np.nan
    assert follower().look(START_NS + 1_000_000_000, angles).verdict is Verdict.FOLLOWS


def test_where_it_should_be() -> None:
    np.testing.assert_allclose(follower().expected(START_NS + 2_000_000_000), [0.2, -0.5])
