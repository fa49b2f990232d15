from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common.renewal import TIMEOUT_S, Renewal

NAMES = ("hip", "knee")
SPEED = 0.15
PERIOD_S = 0.1


def motion(duration: float) -> JointTrajectory:
    """From rest to rest, smoothly, a joint at most at SPEED."""
    times = np.linspace(0.0, duration, max(2, round(50 * duration) + 1))
    way = SPEED * duration / 1.875
    share = times / duration
    way_done = way * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return JointTrajectory(NAMES, times, np.column_stack([way_done, 1.0 - way_done]))


class Robot:
    """Follows the newest piece; a piece begins at the time that it is stamped with."""

    def __init__(self) -> None:
        self._begun, self._piece = 0.0, JointTrajectory(NAMES, np.zeros(1), np.array([[0.0, 1.0]]))

    def take(self, begun: float, piece: JointTrajectory) -> None:
        self._begun, self._piece = begun, piece

    def at(self, time: float) -> FloatArray:
        return self._piece.at(np.array(time - self._begun))

    def speed(self, time: float) -> FloatArray:
        return self._piece.rates(np.array(time - self._begun))


def test_renewed_in_time_it_is_the_trajectory() -> None:
    whole = motion(5.0)
    renewal, robot = Renewal(whole), Robot()
    for time in np.arange(0.0, 6.0, 0.01):
        if renewal.due(time):
            # It comes a little later than it was made.
            robot.take(time, renewal.piece(time))
        np.testing.assert_allclose(robot.at(time), whole.at(np.array(time)), atol=1e-5)
        np.testing.assert_allclose(robot.speed(time), whole.rates(np.array(time)), atol=1e-3)
        assert renewal.path_time(time) == pytest.approx(min(time, 5.0))
    assert renewal.done


@given(st.floats(0.0, 7.0), st.sampled_from([0.5, 1.0, 4.0]))
def test_whenever_the_sender_dies_the_robot_rests_in_time(killed: float, timeout_s: float) -> None:
    whole = motion(6.0)
    renewal, robot = Renewal(whole), Robot()
    for time in np.arange(0.0, killed, 0.01):
        if renewal.due(time):
            piece = renewal.piece(time, timeout_s)
            assert piece.duration <= timeout_s + 1e-9
            assert piece.velocities is not None
            assert not piece.velocities[-1].any(), "a controller refuses to end with a speed"
            robot.take(time, piece)
    rest = robot.at(killed + timeout_s)
    for later in (0.0, 1.0, 10.0):
        np.testing.assert_allclose(robot.at(killed + timeout_s + later), rest, atol=1e-12)
        np.testing.assert_allclose(robot.speed(killed + timeout_s + later), 0.0, atol=1e-12)
    # On the path that was checked: the knee mirrors the hip.
    assert rest.sum() == pytest.approx(1.0)


@given(st.lists(st.floats(0.02, 1.5), min_size=1, max_size=40))
def test_pieces_that_come_late_make_no_speed_jump(gaps: list[float]) -> None:
    """Slowed down, at rest or on its way: place and speed go on, and it comes to the end."""
    whole = motion(3.0)
    renewal, robot = Renewal(whole), Robot()
    time = 0.0
    robot.take(time, renewal.piece(time))
    for gap in [*gaps, *[PERIOD_S] * 60]:
        time += gap
        if renewal.done:
            break
        before = robot.at(time), robot.speed(time)
        robot.take(time, renewal.piece(time))
        np.testing.assert_allclose(robot.at(time), before[0], atol=1e-5)
        np.testing.assert_allclose(robot.speed(time), before[1], atol=2e-3)
        speeds, accelerations = robot._piece.peaks()
        assert speeds.max() <= 1.01 * SPEED
        assert accelerations.max() <= 1.5 * SPEED / (0.4 * TIMEOUT_S)
    assert renewal.done
    np.testing.assert_allclose(robot.at(time + 1.0), whole.positions[-1], atol=1e-9)


def test_a_stop_is_on_the_way() -> None:
    renewal = Renewal(motion(5.0))
    for time in np.arange(0.0, 2.0, PERIOD_S):
        renewal.piece(time)
    assert renewal.stopped(2.0, 0.5) == pytest.approx(2.25)
    assert renewal.stopped(9.0, 0.5) == renewal.stopped(99.0, 0.5), "once at rest it stays"


def test_a_piece_that_was_not_sent_changes_nothing() -> None:
    whole = motion(0.7)
    renewal, other = Renewal(whole), Renewal(whole)
    for one in (renewal, other):
        one.piece(0.0)
    renewal.piece(0.3)
    assert renewal.done
    renewal.take_back()
    assert not renewal.done
    for time in np.linspace(0.0, 2.0, 41):
        assert renewal.due(time) == other.due(time)
        assert renewal.path_time(time) == other.path_time(time)
    # Meanwhile the robot has come to rest.
    np.testing.assert_array_equal(renewal.piece(0.6).positions, other.piece(0.6).positions)


def test_until_a_first_piece_that_comes_late_it_rests() -> None:
    renewal = Renewal(motion(5.0))
    renewal.piece(0.4)
    for time, path in ((0.0, 0.0), (0.39, 0.0), (0.4, 0.0), (0.5, 0.1)):
        assert renewal.path_time(time) == pytest.approx(path)


def test_a_short_one_is_sent_whole() -> None:
    renewal = Renewal(motion(0.3))
    assert renewal.piece(0.0).duration == pytest.approx(0.3)
    assert renewal.done
    assert not renewal.due(1.0)


def test_a_point_at_once_is_allowed() -> None:
    once = JointTrajectory(NAMES, np.array([0.0]), np.ones((1, 2)))
    piece = Renewal(once).piece(0.0)
    np.testing.assert_allclose(piece.positions[-1], 1.0)


def test_it_begins_as_it_is_a_little_late() -> None:
    """The first piece may be asked for a moment after its begin; a motion under way goes on."""
    whole = motion(5.0)
    under_way = JointTrajectory(
        NAMES, np.linspace(0.0, 2.0, 41), whole.at(np.linspace(2.0, 4.0, 41)),
        whole.rates(np.linspace(2.0, 4.0, 41)),
    )  # fmt: skip
    piece = Renewal(under_way).piece(1e-6)
    assert piece.velocities is not None
    np.testing.assert_allclose(piece.velocities[0], whole.rates(np.array(2.0)), atol=1e-6)


@given(st.floats(0.3, 1.2))
def test_its_end_is_reached_exactly(duration: float) -> None:
    renewal = Renewal(motion(duration))
    for time in np.arange(0.0, 2.0, 0.01):
        if renewal.due(time):
            renewal.piece(time)
    assert renewal.path_time(2.0) >= renewal.trajectory.duration
    assert renewal.motion_time(2.0) == pytest.approx(2.0)
