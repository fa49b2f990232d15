"""Stances of a walk, and GRF and CoP of a body that accelerates."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from core.robot import robots
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.run import PoseSamples
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.walking import (
    EDGE_S,
    World,
    derivative,
    in_world,
    walking_stances,
)

SHOE = shoes.shoe("nao_shoe")
ROBOT = replace(robots.kinematics("nao").robot, mass=5.5)
MASS = ROBOT.mass
LIFT = 0.02
"""Of a foot that carries nothing [m]."""
HEIGHT = 0.26
RATE = 100.0
TIME = np.arange(0.0, 12.0, 1.0 / RATE)
OMEGA = 2.0
LEFT, RIGHT = np.array([1.0, 2.0, 0.0]), np.array([1.02, 1.9, 0.0])
PHASES = ((True, True), (True, False), (True, True), (False, True))
"""Three seconds each."""


def turn(yaw: FloatArray | float) -> FloatArray:
    """(..., 3, 3) about z."""
    c, s = np.cos(yaw), np.sin(yaw)
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = [[c, -s, zero], [s, c, zero], [zero, zero, one]]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def world(yaw: float = 0.0, jitter: float = 0.0, lift: float = 0.0) -> World:
    """A body that sways along x over feet that stand, the right one turned by 0.2 rad."""
    count = len(TIME)
    sway = 0.02 * np.sin(OMEGA * TIME)
    bob = lift * np.sin(OMEGA * TIME)
    zero = np.zeros(count)
    com = np.array([1.0, 1.95, HEIGHT]) + np.stack((sway, zero, bob), axis=1)
    noise = jitter * np.where(np.arange(count) % 2, 1.0, -1.0)
    heading = turn(np.stack((yaw + noise, yaw + 0.2 + noise), axis=1))
    sole = np.tile(np.stack((LEFT, RIGHT)), (count, 1, 1))
    sole[..., 2] = LIFT * (loads() == 0.0)
    return World(
        com=com,
        acceleration=-(OMEGA**2) * np.stack((sway, zero, bob), axis=1),
        sole_rotation=heading,
        sole=sole,
        sole_velocity=np.zeros((count, 2, 3)),
        lowest=sole[..., 2],
    )


def loads() -> FloatArray:
    """(T, 2) share of the weight on each foot."""
    shares = []
    for left, right in PHASES:
        pair = [0.5, 0.5] if left and right else [float(left), float(right)]
        shares.append(np.tile(pair, (round(3.0 * RATE), 1)))
    return np.concatenate(shares)


@pytest.fixture
def aligned() -> Aligned:
    """Readings of cells with offsets, no joints."""
    readings = SHOE.polarity * loads()[:, SHOE.foot] * 0.4 + np.linspace(-0.3, 0.3, 8)
    states = robots.kinematics("nao").states(np.zeros((0, 26)))
    return Aligned(TIME, readings, np.zeros((len(TIME), 26)), states)


def test_each_stretch_on_standing_feet_is_a_stance(aligned: Aligned) -> None:
    stances = walking_stances(7, aligned, world(), SHOE, ROBOT)
    assert [stance.loaded for stance in stances] == list(PHASES)
    assert {stance.run for stance in stances} == {7}
    for number, stance in enumerate(stances):
        start, end = 3.0 * number, 3.0 * (number + 1)
        assert start + EDGE_S - 0.01 <= stance.time[0] <= start + EDGE_S + 0.02
        assert end - EDGE_S - 0.03 <= stance.time[-1] <= end - EDGE_S + 0.01
        inside = np.isin(TIME, stance.time)
        np.testing.assert_array_equal(stance.readings, aligned.readings[inside])


@pytest.mark.parametrize("yaw", [0.0, 0.7, 3.0, math.pi, -math.pi + 0.01])
def test_the_cop_is_the_zero_moment_point_in_the_standing_foot_s_frame(
    aligned: Aligned, yaw: float
) -> None:
    lift = 0.01
    for stance in walking_stances(1, aligned, world(yaw, jitter=0.02, lift=lift), SHOE, ROBOT):
        sway = 0.02 * np.sin(OMEGA * stance.time)
        bob = lift * np.sin(OMEGA * stance.time)
        up = GRAVITY - OMEGA**2 * bob
        np.testing.assert_allclose(stance.force, MASS * up, rtol=1e-12)
        # The linear inverted pendulum's zero-moment point goes further than its CoM.
        zmp = np.stack(
            (1.0 + sway * (1.0 + OMEGA**2 * (HEIGHT + bob) / up), np.full_like(sway, 1.95)), axis=1
        )
        frame = stance.loaded.index(True)
        sole, heading = (LEFT, RIGHT)[frame], yaw + (0.0, 0.2)[frame]
        expected = (zmp - sole[:2]) @ turn(heading)[:2, :2]
        np.testing.assert_allclose(stance.cop, expected, atol=1e-9)


@pytest.mark.parametrize("yaw", [0.0, math.pi, -math.pi + 0.01])
def test_the_right_foot_is_where_it_is(aligned: Aligned, yaw: float) -> None:
    both = walking_stances(1, aligned, world(yaw, jitter=0.02), SHOE, ROBOT)[0]
    expected = (RIGHT - LEFT)[:2] @ turn(yaw)[:2, :2]
    np.testing.assert_allclose(both.support.translation, expected, atol=1e-9)
    assert both.support.dtheta == pytest.approx(0.2, abs=1e-9)


def test_a_foot_that_slides_or_tilts_does_not_stand(aligned: Aligned) -> None:
    standing = world()
    velocity = standing.sole_velocity.copy()
    velocity[TIME < 6.0, 0, 0] = 0.1
    found = walking_stances(1, aligned, replace(standing, sole_velocity=velocity), SHOE, ROBOT)
    assert [stance.loaded for stance in found] == list(PHASES[2:])
    rotation = standing.sole_rotation.copy()
    tilt = pin.rpy.rpyToMatrix(0.1, 0.0, 0.0)
    rotation[TIME >= 9.0, 1] = rotation[TIME >= 9.0, 1] @ tilt
    found = walking_stances(1, aligned, replace(standing, sole_rotation=rotation), SHOE, ROBOT)
    assert [stance.loaded for stance in found] == list(PHASES[:3])


def test_without_a_stance_it_says_what_was_found(aligned: Aligned) -> None:
    sliding = replace(world(), sole_velocity=np.ones((len(TIME), 2, 3)))
    found = r"left foot flat, still and loaded for 0\.0 s, in the air for 3\.0 s"
    with pytest.raises(ShoecalError, match=rf"run 5: no stance was found in 12\.0 s \({found}"):
        walking_stances(5, aligned, sliding, SHOE, ROBOT)


def test_stamps_that_jitter_are_not_differentiated_as_if_even() -> None:
    rng = np.random.default_rng(3)
    time = np.sort(np.arange(0.0, 4.0, 0.01) + rng.uniform(-0.004, 0.004, 400))
    time = np.delete(time, slice(100, 104))
    values = np.stack((np.sin(2.0 * time), time), axis=1)
    slope = derivative(values, time, 1)
    inside = slice(30, -30)
    np.testing.assert_allclose(slope[inside, 0], 2.0 * np.cos(2.0 * time[inside]), atol=5e-3)
    np.testing.assert_allclose(slope[inside, 1], 1.0, atol=1e-6)
    bend = derivative(values, time, 2)
    np.testing.assert_allclose(bend[inside, 0], -4.0 * np.sin(2.0 * time[inside]), atol=0.15)


def test_a_gap_in_the_recording_ends_a_stance(aligned: Aligned) -> None:
    kept = (TIME < 1.4) | (TIME > 1.6)
    whole = world()
    gap = World(**{name: getattr(whole, name)[kept] for name in World.__dataclass_fields__})
    cut = Aligned(TIME[kept], aligned.readings[kept], aligned.joint_angles[kept], aligned.states)
    stances = walking_stances(1, cut, gap, SHOE, ROBOT)
    assert [stance.loaded for stance in stances] == [PHASES[0], *PHASES]


# ---- the body in the world --------------------------------------------------------------------


def test_the_body_in_the_world_is_pinocchio_s() -> None:
    kinematics = robots.kinematics("nao")
    robot = kinematics.robot
    time = np.arange(0.0, 1.0, 0.02)
    angles = np.tile(robot.posture, (len(time), 1))
    knee = robot.joint("LKneePitch")
    angles[:, knee] += 0.1 * np.sin(3.0 * time)
    pin.seed(3)
    pose = pin.SE3.Random()
    quaternion = pin.Quaternion(pose.rotation).coeffs()
    # One and the same turn, told with either sign.
    base = PoseSamples(
        np.array([0.0, 0.5, 1.0]), np.tile(pose.translation, (3, 1)),
        np.stack((quaternion, -quaternion, quaternion)),
    )  # fmt: skip
    aligned = Aligned(time, np.zeros((len(time), 8)), angles, kinematics.states(angles))
    found = in_world(aligned, base, kinematics.robot)
    data = robot.model.createData()
    for index in (0, 20, 49):
        q = np.concatenate((pin.SE3ToXYZQUAT(pose), angles[index]))
        com = pin.centerOfMass(robot.model, data, q)
        pin.updateFramePlacements(robot.model, data)
        np.testing.assert_allclose(found.com[index], com, atol=1e-12)
        for foot in (0, 1):
            sole = data.oMf[robot.feet[foot].frame]
            np.testing.assert_allclose(found.sole[index, foot], sole.translation, atol=1e-12)
            np.testing.assert_allclose(found.sole_rotation[index, foot], sole.rotation, atol=1e-12)


def test_accelerations_of_a_base_that_is_thrown() -> None:
    """A parabola is a cubic to the smoother: exact up to the ends."""
    kinematics = robots.kinematics("nao")
    time = np.arange(0.0, 1.0, 0.01)
    angles = np.tile(kinematics.robot.posture, (len(time), 1))
    position = np.stack((0.3 * time, np.zeros_like(time), 2.0 * time - 0.5 * 9.0 * time**2), axis=1)
    base = PoseSamples(time, position, np.tile([0.0, 0.0, 0.0, 1.0], (len(time), 1)))
    aligned = Aligned(time, np.zeros((len(time), 8)), angles, kinematics.states(angles))
    found = in_world(aligned, base, kinematics.robot)
    np.testing.assert_allclose(found.acceleration, np.tile([0.0, 0.0, -9.0], (100, 1)), atol=1e-8)
    np.testing.assert_allclose(found.sole_velocity[:, 1, 2], 2.0 - 9.0 * time, atol=1e-9)
    few = Aligned(time[:20], aligned.readings[:20], angles[:20], kinematics.states(angles[:20]))
    with pytest.raises(ShoecalError, match="20 samples are too few for accelerations"):
        in_world(few, base, kinematics.robot)
