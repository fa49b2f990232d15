from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common.renewal import Renewal
from shoecal_ros.planner.following import Follower, FollowingState

START_NS = 5_000_000_000
TRAJECTORY = JointTrajectory(
    ("a", "b"),
    np.linspace(0.0, 4.0, 41),
    np.column_stack([0.1 * np.linspace(0.0, 4.0, 41), np.full(41, -0.5)]),
)


def follower() -> Follower:
    renewal = Renewal(TRAJECTORY)
    for time in np.arange(0.0, 4.0, 0.1):
        renewal.piece(time)
    return Follower(TRAJECTORY, renewal, START_NS, error_bound=0.05, late_s=0.5)


def at(time: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.asarray(TRAJECTORY.at(np.array(time)))


@given(st.floats(0.0, 4.4), st.floats(0.0, 0.5))
def test_a_late_robot_follows(time: float, late: float) -> None:
    look = follower().look(START_NS + round(time * 1e9), at(time - late))
    assert look.verdict is FollowingState.FOLLOWS
    assert look.error < 0.01


@given(st.floats(0.0, 6.0), st.sampled_from([0, 1]), st.sampled_from([-1, 1]))
def test_a_joint_far_off_is_lost_and_named(time: float, joint: int, side: int) -> None:
    one, angles = follower(), at(time).copy()
    angles[joint] += side * 0.2
    looks = [one.look(START_NS + round((time + late) * 1e9), angles) for late in (0.0, 0.01, 0.02)]
    assert [look.verdict for look in looks] == [
        FollowingState.DOUBTFUL,
        FollowingState.DOUBTFUL,
        FollowingState.LOST,
    ]
    assert looks[-1].joint == TRAJECTORY.names[joint]


@given(st.floats(0.0, 4.4), st.lists(st.integers(0, 2), max_size=20))
def test_one_or_two_false_measurements_in_a_row_are_doubtful(time: float, runs: list[int]) -> None:
    one = follower()
    for number, false in enumerate(runs):
        for index in range(3):
            stamp_ns = START_NS + round(time * 1e9) + 1_000_000 * (3 * number + index)
            is_false = index < false
            look = one.look(stamp_ns, at(time) + 0.9 * is_false)
            assert look.verdict is (FollowingState.DOUBTFUL if is_false else FollowingState.FOLLOWS)


def test_measurements_that_come_seldom_need_fewer() -> None:
    one = follower()
    times = (1.0, 1.1)
    looks = [one.look(START_NS + round(time * 1e9), at(1.0) + 0.9) for time in times]
    assert [look.verdict for look in looks] == [FollowingState.DOUBTFUL, FollowingState.LOST]


@given(st.floats(0.0, 4.4), st.floats(-2.0, 2.0))
def test_it_stops_where_it_is_and_not_far_from_where_it_was_seen(time: float, way: float) -> None:
    one = follower()
    stamp_ns = START_NS + round(time * 1e9)
    np.testing.assert_array_equal(one.at_rest(at(0.0)), at(0.0))
    one.look(stamp_ns, at(time))
    rest = one.at_rest(at(time) + way)
    assert np.abs(rest - at(time)).max() <= 0.05 + 1e-6
    if abs(way) < 0.04:
        np.testing.assert_allclose(rest, at(time) + way)


def test_a_robot_that_never_starts_is_lost() -> None:
    one = follower()
    verdicts = [
        one.look(START_NS + round(time * 1e9), at(0.0)).verdict for time in np.arange(0.0, 3.0, 0.1)
    ]
    assert verdicts[0] is FollowingState.FOLLOWS
    assert verdicts[-1] is FollowingState.LOST


def test_it_has_arrived_when_even_a_late_robot_must_have() -> None:
    assert follower().look(START_NS + 4_400_000_000, at(4.0)).verdict is FollowingState.FOLLOWS
    look = follower().look(START_NS + 4_600_000_000, at(4.0))
    assert look.verdict is FollowingState.ARRIVED
    assert look.progress == pytest.approx(1.0)


def test_a_robot_that_stopped_on_the_way_has_not_arrived() -> None:
    one = follower()
    verdicts = [one.look(START_NS + stamp_ns, at(2.0)).verdict for stamp_ns in (9 * 10**9, 10**10)]
    assert verdicts == [FollowingState.DOUBTFUL, FollowingState.LOST]


def test_a_joint_that_tells_nothing_does_not_count() -> None:
    angles = at(1.0).copy()
    angles[1] = np.nan
    assert follower().look(START_NS + 1_000_000_000, angles).verdict is FollowingState.FOLLOWS


def test_a_robot_that_was_sent_no_more_is_to_be_where_that_ended() -> None:
    renewal = Renewal(TRAJECTORY)
    renewal.piece(0.0)
    one = Follower(TRAJECTORY, renewal, START_NS, error_bound=0.05, late_s=0.5)
    rest = renewal.path_time(9.0)
    assert 0.3 < rest < 0.5
    look = one.look(START_NS + 9 * 10**9, at(rest))
    assert look.verdict is FollowingState.FOLLOWS
    assert look.error == pytest.approx(0.0)
    assert look.progress == pytest.approx(rest / 4.0)
