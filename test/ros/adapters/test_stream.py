"""Set points of trajectories."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.bodies import nao
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.adapters.foreign import PackageMissingError, foreign
from shoecal_ros.adapters.lola import NUMBERS, numbered
from shoecal_ros.adapters.stream import REPEATED_S, STOP_S, Stream
from shoecal_ros.common.renewal import Renewal

KNEE = "LKneePitch"
STEP_S = 1e-4
MOST_ACCELERATION = 500.0
"""rad/s^2; more than the drawn motions have: a jump by 1 rad/s would look like 10,000."""
UNIT = st.floats(0.0, 1.0)


def bend(times: list[float], ways: list[float]) -> JointTrajectory:
    start = nao().posture[nao().joint(KNEE)]
    return JointTrajectory((KNEE,), np.array(times), start + np.array(ways)[:, None])


def test_a_motion_that_begins_waits_for_no_module() -> None:
    """A node that stood still for half a second would count as gone, and its motion be stopped."""
    program = """
import sys
import numpy as np
from shoecal_core.robot.joint_trajectory import JointTrajectory
import shoecal_ros.adapters.stream
before = set(sys.modules)
JointTrajectory(("knee",), np.arange(3.0), np.zeros((3, 1))).rates(np.array(0.5))
print(sorted(set(sys.modules) - before))
"""
    result = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert result.stdout == "[]\n"


@st.composite
def drawn_motions(draw: st.DrawFn) -> JointTrajectory:
    """Some joints between their limits, from where they stand, within 0.5 to 5 s."""
    robot = nao()
    names = draw(
        st.lists(st.sampled_from((KNEE, "RAnkleRoll", "HeadYaw")), min_size=1, unique=True)
    )
    columns = [robot.joint(name) for name in names]
    count = draw(st.integers(1, 6))
    times = np.linspace(0.0, draw(st.floats(0.5, 5.0)), count + 1)
    shares = draw(st.lists(st.tuples(*[UNIT] * len(names)), min_size=count, max_size=count))
    lower, upper = robot.lower[columns], robot.upper[columns]
    positions = np.vstack((robot.posture[columns], lower + np.array(shares) * (upper - lower)))
    return JointTrajectory(tuple(names), times, positions)


def sampled(stream: Stream, times: FloatArray) -> FloatArray:
    """(T, k) set points."""
    points = [point for time_s in times if (point := stream.at(float(time_s))) is not None]
    assert len(points) == len(times)
    return np.array(points)


def test_it_is_silent_before_and_after() -> None:
    stream = Stream(nao())
    assert stream.at(5.0) is None
    stream.begin(bend([0.0, 2.0], [0.0, 0.2]), nao().posture, 10.0)
    assert stream.active
    last = stream.at(12.0 + REPEATED_S)
    assert last is not None
    assert last[0] - nao().posture[nao().joint(KNEE)] == pytest.approx(0.2)
    assert stream.at(12.1 + REPEATED_S) is None
    assert not stream.active


def test_a_first_point_that_comes_later_is_moved_to() -> None:
    """From where the joints were last told to be, be that a little off what is measured."""
    stream, start = Stream(nao()), nao().posture[nao().joint(KNEE)]
    stream.begin(bend([0.0, 2.0], [0.0, 0.2]), nao().posture, 0.0)
    stream.begin(bend([1.0], [0.0]), nao().posture, 2.0)
    first, middle, end = (stream.at(time_s) for time_s in (2.0, 2.5, 3.0))
    assert first is not None
    assert middle is not None
    assert end is not None
    assert first[0] - start == pytest.approx(0.2)
    assert 0.05 < middle[0] - start < 0.15
    assert end[0] - start == pytest.approx(0.0)


def test_it_stops_smoothly_on_its_way() -> None:
    """From v to rest in STOP_S evenly, which takes half the way of going on."""
    stream, start = Stream(nao()), nao().posture[nao().joint(KNEE)]
    speed = 0.1
    times = np.linspace(0.0, 4.0, 9)
    stream.begin(bend(times.tolist(), (speed * times).tolist()), nao().posture, 0.0)
    stream.stop(2.0)
    assert stream.under_way(2.1)
    for since in (0.0, 0.1, 0.3, STOP_S, 2.0 * STOP_S):
        until = min(since, STOP_S)
        way = speed * (2.0 + until * (1.0 - 0.5 * until / STOP_S))
        assert stream.at(2.0 + since) == pytest.approx(start + way)
    assert not stream.under_way(2.0 + STOP_S)
    assert stream.at(2.1 + STOP_S + REPEATED_S) is None


@given(drawn_motions(), UNIT)
def test_a_stop_stays_on_the_trajectory(motion: JointTrajectory, share: float) -> None:
    """Each joint passes the places that it would have passed, ever more slowly, and then rests."""
    streams = [Stream(nao()) for _ in range(2)]
    for stream in streams:
        stream.begin(motion, nao().posture, 0.0)
    stopped, going_on = streams
    stop_s = share * motion.duration
    stopped.stop(stop_s)
    since = np.linspace(0.0, STOP_S, 5)
    points = sampled(stopped, stop_s + since)
    assert points == pytest.approx(sampled(going_on, stop_s + since * (1 - 0.5 * since / STOP_S)))
    rest = points[-1]
    assert not np.diff(sampled(stopped, stop_s + STOP_S * np.array([1.0, 1.5, 2.0])), axis=0).any()
    # Told again, nothing changes.
    for again in (0.5, 1.5):
        stopped.stop(stop_s + again * STOP_S)
        assert stopped.at(stop_s + (again + 0.5) * STOP_S) == pytest.approx(rest)


@given(drawn_motions(), drawn_motions(), UNIT, st.one_of(st.none(), UNIT))
def test_a_new_trajectory_is_passed_over_to(
    old: JointTrajectory, new: JointTrajectory, share: float, stopping: float | None
) -> None:
    """On the way or in the midst of a stop: speeds do not jump, and no limit is passed."""
    robot, stream, now_s = nao(), Stream(nao()), share * old.duration
    stream.begin(old, robot.posture, 0.0)
    if stopping is not None:
        stream.stop(now_s)
        now_s += stopping * STOP_S
    earlier = sampled(stream, np.array([now_s - STEP_S, now_s]))
    stream.begin(new, robot.posture, now_s)
    assert set(stream.names) == {*old.names, *new.names}
    reported = [stream.names.index(name) for name in old.names]
    here, soon = sampled(stream, np.array([now_s, now_s + STEP_S]))[:, reported]
    assert here == pytest.approx(earlier[1])
    assert soon - here == pytest.approx(here - earlier[0], abs=MOST_ACCELERATION * STEP_S**2)
    points = sampled(stream, np.linspace(now_s, now_s + max(new.duration, STOP_S), 20))
    columns = [robot.joint(name) for name in stream.names]
    assert (points >= robot.lower[columns] - 1e-6).all()
    assert (points <= robot.upper[columns] + 1e-6).all()
    ends = [stream.names.index(name) for name in new.names]
    assert points[-1, ends] == pytest.approx(new.positions[-1])


def test_no_limit_is_passed_by_a_motion_that_touched_it() -> None:
    """The remembered motion is between points, and turns sharply at the limit."""
    robot, stream = nao(), Stream(nao())
    low = robot.lower[robot.joint("RAnkleRoll")]
    times, ways = np.linspace(0.0, 1.25, 4), np.array([0.0, 0.397761, low, low])
    stream.begin(JointTrajectory(("RAnkleRoll",), times, ways[:, None]), robot.posture, 0.0)
    stream.begin(bend([0.0, 1.0], [0.0, -0.8923279]), robot.posture, 0.625)
    points = sampled(stream, np.linspace(0.625, 1.625, 500))
    assert points[:, stream.names.index("RAnkleRoll")].min() >= low - 1e-6


def test_joints_that_were_told_nothing_begin_where_they_are() -> None:
    """Whoever has moved them since the motion before began."""
    robot, stream = nao(), Stream(nao())
    stream.begin(bend([0.0, 1.0], [0.0, 0.1]), robot.posture, 0.0)
    arm = robot.joint("LShoulderPitch")
    measured = robot.posture.copy()
    measured[arm] = 0.65
    stay = JointTrajectory(("LShoulderPitch",), np.array([2.0]), np.array([[0.65]]))
    stream.begin(stay, measured, 0.5)
    points = sampled(stream, np.linspace(0.5, 2.5, 21))[:, stream.names.index("LShoulderPitch")]
    assert points == pytest.approx(0.65)


def test_a_robot_that_was_given_nothing_goes_on_from_where_it_was_left() -> None:
    """The sender was asleep: set points do not jump to where it would be by now."""
    stream = Stream(nao())
    stream.begin(bend([0.0, 2.0], [0.0, 0.3]), nao().posture, 0.0)
    (last,) = sampled(stream, np.array([0.8]))
    stream.rest(0.8, 1.7)
    assert sampled(stream, np.array([1.7, 1.75, 2.5])) == pytest.approx(np.tile(last, (3, 1)))
    stream.begin(bend([0.0, 2.0], [0.2, 0.3]), nao().posture, 1.8)
    points = sampled(stream, np.array([1.8, 1.8 + STEP_S, 4.0]))
    assert points[:2] == pytest.approx(np.tile(last, (2, 1)), abs=1e-6)
    assert points[2, 0] - nao().posture[nao().joint(KNEE)] == pytest.approx(0.3)


@given(st.lists(st.floats(0.05, 0.15), min_size=5, max_size=20))
def test_pieces_of_one_motion_are_that_motion(gaps: list[float]) -> None:
    share = np.linspace(0.0, 1.0, 81)
    ways = 0.2 * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    whole = bend((4.0 * share).tolist(), ways.tolist())
    renewal, stream = Renewal(whole), Stream(nao())
    for now in np.cumsum([0.0, *gaps]):
        stream.begin(renewal.piece(now), nao().posture, now)
        times = now + np.linspace(0.0, 0.19, 5)
        assert sampled(stream, times) == pytest.approx(whole.at(times), abs=1e-3)


def test_a_thousand_trajectories_in_a_second_are_borne() -> None:
    robot, stream = nao(), Stream(nao())
    knee = robot.joint(KNEE)
    places = []
    for index in range(1000):
        way = 0.3 if index % 2 else 0.0
        stream.begin(bend([0.0, 0.5], [0.0, way]), robot.posture, index / 1000)
        reported = stream.at(index / 1000)
        assert reported is not None
        places.append(reported[0] - robot.posture[knee])
    assert abs(np.diff(places)).max() < 0.01


def test_limits_hold() -> None:
    with pytest.raises(ShoecalError, match="beyond its limits"):
        Stream(nao()).begin(bend([0.0, 1.0], [0.0, 9.0]), nao().posture, 0.0)


def test_numbers_of_lola() -> None:
    """Both hips are one motor, which has the left one's number."""
    assert len(NUMBERS) == 25
    assert set(nao().joint_names) - set(NUMBERS) == {"RHipYawPitch"}
    assert numbered(["RHipYawPitch", "RHand", "HeadYaw"], [0.1, 0.2, 0.3]) == ([24, 0], [0.2, 0.3])


def test_a_package_that_is_not_installed_is_told() -> None:
    with pytest.raises(PackageMissingError) as error:
        foreign("no_such_msgs", "msg", "Nothing")
    assert "sudo apt install ros-jazzy-no-such-msgs" in str(error.value)
