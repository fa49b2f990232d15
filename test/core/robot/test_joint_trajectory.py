from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.errors import NameNotFoundError, ShapeError, ShoecalError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.robot import Robot


def trajectory(times: list[float], positions: list[list[float]], *names: str) -> JointTrajectory:
    return JointTrajectory(names, np.array(times), np.array(positions))


@given(st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=12))
def test_it_passes_its_points_from_rest_to_rest(points: list[float]) -> None:
    times = np.linspace(0.0, 3.0, len(points))
    planned = JointTrajectory(("a",), times, np.array(points)[:, None])
    assert planned.at(times)[:, 0] == pytest.approx(np.array(points), abs=1e-12)
    step = 1e-6
    for end in (0.0, 3.0):
        rate = (planned.at(np.array(end + step)) - planned.at(np.array(end - step))) / step
        assert rate == pytest.approx([0.0], abs=1e-3)
    between = planned.at(np.linspace(0.0, 3.0, 500))
    assert between.min() >= min(points) - 1e-9
    assert between.max() <= max(points) + 1e-9


@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=6), st.floats(-0.5, 3.5))
def test_rates_are_how_its_places_change(points: list[float], time_s: float) -> None:
    planned = trajectory(np.linspace(0.0, 3.0, len(points)).tolist(), [[p] for p in points], "a")
    step = 1e-6
    ways = planned.at(np.array([time_s - step, time_s + step]))
    difference = (ways[1] - ways[0]) / (2.0 * step)
    assert planned.rates(np.array(time_s)) == pytest.approx(difference, abs=1e-3)


def test_it_holds_its_ends() -> None:
    planned = trajectory([0.0, 1.0, 2.0], [[0.0], [0.5], [0.4]], "a")
    assert planned.at(np.array([-1.0, 2.0, 99.0]))[:, 0] == pytest.approx([0.0, 0.4, 0.4])


def test_joints_not_named_stay(nao: Robot) -> None:
    start = nao.posture
    planned = trajectory([1.0, 2.0], [[0.1], [0.2]], "HeadYaw").full(nao, start)
    assert planned.names == nao.joint_names
    assert planned.times == pytest.approx([0.0, 1.0, 2.0])
    moved = np.flatnonzero(np.ptp(planned.positions, axis=0))
    assert moved.tolist() == [nao.joint("HeadYaw")]
    assert planned.positions[0] == pytest.approx(start)


@pytest.mark.parametrize("name", ["LHipYawPitch", "RHipYawPitch"])
def test_one_motor_moves_both_of_its_joints(nao: Robot, name: str) -> None:
    planned = trajectory([0.0], [[-0.2]], name).full(nao, nao.posture)
    for joint in ("LHipYawPitch", "RHipYawPitch"):
        assert planned.positions[0, nao.joint(joint)] == pytest.approx(-0.2)


@pytest.mark.parametrize(
    ("times", "positions", "message"),
    [
        ([0.0, 0.0], [[0.0], [0.1]], "must increase"),
        ([-1.0, 0.0], [[0.0], [0.1]], "must increase"),
        ([0.0, np.inf], [[0.0], [0.1]], "not finite"),
        ([0.0, 1.0], [[0.0], [np.nan]], "not finite"),
    ],
)
def test_what_is_no_trajectory_is_refused(
    times: list[float], positions: list[list[float]], message: str
) -> None:
    with pytest.raises(ShoecalError, match=message):
        trajectory(times, positions, "a")


def test_one_that_names_no_joint_is_refused() -> None:
    with pytest.raises(ShoecalError, match="names no joint; correct its sender"):
        JointTrajectory((), np.zeros(1), np.zeros((1, 0)))


def test_shapes_must_fit() -> None:
    with pytest.raises(ShapeError):
        trajectory([0.0, 1.0], [[0.0]], "a")
    with pytest.raises(ShapeError):
        JointTrajectory(("a",), np.zeros(0), np.zeros((0, 1)))


def test_what_the_robot_cannot_do_is_refused(nao: Robot) -> None:
    start = nao.posture
    with pytest.raises(NameNotFoundError, match="'Tail'"):
        trajectory([0.0], [[0.0]], "Tail").full(nao, start)
    with pytest.raises(
        ShoecalError, match=r"'LKneePitch' is commanded to move .* beyond its limits"
    ):
        trajectory([0.0], [[3.0]], "LKneePitch").full(nao, start)
    with pytest.raises(ShoecalError, match="are one motor"):
        trajectory([0.0], [[0.1, 0.2]], "LHipYawPitch", "RHipYawPitch").full(nao, start)
