"""Joint angles of the whole robot, from the planned legs and from what a driver tells."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from core.robot import robots
from shoecal_core.errors import NameNotFoundError, ShapeError, ShoecalError
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import JointsMissingError, Robot

FOLLOWER, LEADER = "RHipYawPitch", "LHipYawPitch"


def test_weight_names_and_limits(robot: Robot) -> None:
    assert robot.weight == robot.mass * GRAVITY
    assert sum(inertia.mass for inertia in robot.model.inertias) == pytest.approx(robot.mass)
    # The torso rides on the free base: it must not be lost.
    assert robot.model.inertias[1].mass > 0.1 * robot.mass
    count = len(robot.joint_names)
    for limits in (robot.lower, robot.upper, robot.velocity_limit, robot.effort_limit):
        assert limits.shape == (count,)
    assert (robot.lower < robot.upper).all()
    assert robot.leg_names == tuple(robot.joint_names[index] for index in robot.legs)
    for index, name in enumerate(robot.joint_names):
        assert robot.joint(name) == index
        joint = robot.model.getJointId(name)
        assert robot.lower[index] == robot.model.lowerPositionLimit[robot.model.idx_qs[joint]]


@pytest.mark.parametrize(
    ("corners", "counts"),
    [
        ([(-1, -1), (2, -1), (2, 1), (-1, 1)], [1, 1, 1, 1]),
        ([(-2, -1), (2, -1), (4, 0), (2, 1), (-2, 1), (-2, 0)], [1, 2, 2, 2]),
        ([(-1, -1), (2, 0), (-1, 1)], [1, 1, 1, 1]),
    ],
)
def test_a_point_on_a_sole_is_within_all_its_sides(
    corners: list[tuple[float, float]], counts: list[int]
) -> None:
    outline = np.array(corners, dtype=float)
    sides = dataclasses.replace(robots.load("wren").feet[0], outline=outline).sides
    assert [len(offsets) for _, offsets in sides] == counts
    sole = shapely.Polygon(outline)
    for point in np.random.default_rng(0).uniform(-3.0, 3.0, (200, 2)):
        least = min(float(np.min(offsets - normals @ point)) for normals, offsets in sides)
        place = shapely.Point(point)
        assert (least > 0.0) == sole.contains(place)
        if least > 0.0:
            assert least == pytest.approx(sole.exterior.distance(place))


def test_a_joint_that_is_not_there(robot: Robot) -> None:
    with pytest.raises(NameNotFoundError, match="no joint named 'Tail'"):
        robot.joint("Tail")


@pytest.mark.parametrize("shape", [(), (4,), (2, 3)])
def test_planned_legs_move_and_the_rest_stays(robot: Robot, shape: tuple[int, ...]) -> None:
    legs = np.random.default_rng(0).uniform(-0.1, 0.1, (*shape, len(robot.legs)))
    followers = [shared.joint for shared in robot.shared]
    rest = np.setdiff1d(np.arange(len(robot.joint_names)), [*robot.legs, *followers])
    others = np.linspace(-0.2, 0.2, len(robot.joint_names))
    for given_others, base in ((None, robot.posture), (others, others)):
        angles = robot.from_legs(legs, given_others)
        assert angles.shape == (*shape, len(robot.joint_names))
        np.testing.assert_array_equal(angles[..., robot.legs], legs)
        np.testing.assert_array_equal(
            angles[..., rest], np.broadcast_to(base[rest], (*shape, len(rest)))
        )
        for shared in robot.shared:
            np.testing.assert_array_equal(
                angles[..., shared.joint], shared.ratio * angles[..., shared.leader]
            )
    with pytest.raises(ShapeError, match="leg angles"):
        robot.from_legs(np.zeros(len(robot.legs) + 1))


def test_the_nao_s_hips_share_a_motor(nao: Robot) -> None:
    (shared,) = nao.shared
    assert nao.joint_names[shared.joint] == FOLLOWER
    assert nao.joint_names[shared.leader] == LEADER
    assert shared.ratio == 1.0
    assert FOLLOWER not in nao.leg_names
    legs = np.zeros(len(nao.legs))
    legs[nao.leg_names.index(LEADER)] = -0.3
    assert nao.from_legs(legs)[nao.joint(FOLLOWER)] == -0.3


@given(st.data())
@settings(max_examples=30)
def test_measured_joints_come_in_any_order(data: st.DataObject) -> None:
    robot = robots.load(data.draw(st.sampled_from(robots.NAMES)))
    truth = robots.random_angles(robot, 3, seed=data.draw(st.integers(0, 99)))
    names = data.draw(st.permutations([*robot.joint_names, "Wheel", "Antenna"]))
    told = np.array([
        truth[:, robot.joint_names.index(name)] if name in robot.joint_names else [9.0, 9.0, 9.0]
        for name in names
    ]).T  # fmt: skip
    np.testing.assert_array_equal(robot.from_measured(names, told), truth)
    np.testing.assert_array_equal(robot.from_measured(names, told[1]), truth[1])


def test_a_follower_is_told_once_or_twice(nao: Robot) -> None:
    truth = robots.random_angles(nao, 4)
    names = [name for name in nao.joint_names if name != FOLLOWER]
    columns = [nao.joint(name) for name in names]
    np.testing.assert_array_equal(nao.from_measured(names, truth[:, columns]), truth)
    # Told by its own encoder, it is taken at its word.
    own = truth.copy()
    own[:, nao.joint(FOLLOWER)] += 0.01
    np.testing.assert_array_equal(nao.from_measured(nao.joint_names, own), own)


def test_optional_joints_may_be_absent_or_nan(nao: Robot) -> None:
    truth = robots.random_angles(nao, 4)
    optional = [nao.joint(name) for name in sorted(nao.optional)]
    expected = truth.copy()
    expected[:, optional] = nao.posture[optional]
    names = [name for name in nao.joint_names if name not in nao.optional]
    columns = [nao.joint(name) for name in names]
    np.testing.assert_array_equal(nao.from_measured(names, truth[:, columns]), expected)
    silent = truth.copy()
    silent[:, optional] = np.nan
    np.testing.assert_array_equal(nao.from_measured(nao.joint_names, silent), expected)
    partly = truth.copy()
    partly[1:, optional] = np.nan
    expected[0] = truth[0]
    np.testing.assert_array_equal(nao.from_measured(nao.joint_names, partly), expected)


def test_nan_of_a_needed_joint_stays_nan(nao: Robot) -> None:
    told = np.tile(nao.posture, (2, 1))
    told[0, nao.joint("LKneePitch")] = np.nan
    angles = nao.from_measured(nao.joint_names, told)
    assert np.isnan(angles[0, nao.joint("LKneePitch")])
    assert np.isfinite(angles[1]).all()


def test_missing_joints_are_all_named(robot: Robot) -> None:
    gone = [robot.leg_names[2], robot.leg_names[-1]]
    names = [name for name in robot.joint_names if name not in gone]
    with pytest.raises(JointsMissingError) as caught:
        robot.from_measured(names, np.zeros((5, len(names))))
    assert caught.value.missing == tuple(sorted(gone, key=robot.joint))
    assert isinstance(caught.value, ShoecalError)
    for name in gone:
        assert name in str(caught.value)
    assert "check the robot file's joint names" in str(caught.value)
    with pytest.raises(JointsMissingError, match="only these were given: none"):
        robot.from_measured([], np.zeros((5, 0)))
    with pytest.raises(ShapeError, match="positions"):
        robot.from_measured(robot.joint_names, np.zeros((5, 3)))


def test_a_leader_cannot_be_left_out(nao: Robot) -> None:
    names = [name for name in nao.joint_names if name != LEADER]
    with pytest.raises(JointsMissingError, match=LEADER):
        nao.from_measured(names, np.zeros(len(names)))


def test_angles_given_are_not_written_to(nao: Robot) -> None:
    told = np.full((2, len(nao.joint_names)), np.nan)
    before = told.copy()
    posture = nao.posture.copy()
    nao.from_measured(nao.joint_names, told)
    nao.from_legs(np.ones(len(nao.legs)))[:] = 5.0
    np.testing.assert_array_equal(told, before)
    np.testing.assert_array_equal(nao.posture, posture)
