from __future__ import annotations

import dataclasses
import itertools
import math

import numpy as np
import pytest
import shapely
from hypothesis import assume, example, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from core.planning.bodies import NAMES, load_body
from core.planning.motions import SETTINGS
from core.planning.test_support_phase import supports
from shoecal_core.arrays import FloatArray
from shoecal_core.planning import swing
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.planning.swing import (
    STEP_WAY,
    NoSwingPathError,
    interpolated_poses,
    lifted,
    swing_path,
    vertical_states,
)
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot

ONE = st.sampled_from([SupportPhase.LEFT, SupportPhase.RIGHT])
apart = st.builds(
    DoubleSupport, st.floats(-0.04, 0.08), st.floats(-0.16, -0.125), st.floats(-0.2, 0.2)
)
"""Of most the feet do not overlap."""
WIDE = DoubleSupport(0.0, -0.14, 0.0)


def swing_segment(poses: tuple[FootPose, ...], support_phase: SupportPhase) -> list[FootPose]:
    """Of the foot that does not carry, in the other one's frame."""
    return [pose.inverse if support_phase is SupportPhase.RIGHT else pose for pose in poses]


def corners(robot: Robot, poses: tuple[FootPose, ...], support_phase: SupportPhase) -> FloatArray:
    """(n, c, 3) of the sole in the air, seen from the other one [m]."""
    foot = robot.feet[0 if support_phase is SupportPhase.RIGHT else 1]
    outline = np.column_stack([foot.outline, np.zeros(len(foot.outline))])
    return np.array(
        [
            outline @ pose.rotation.T + pose.translation
            for pose in swing_segment(poses, support_phase)
        ]
    )


def gaps(robot: Robot, poses: tuple[FootPose, ...]) -> FloatArray:
    left, right = (foot.outline for foot in robot.feet)
    return np.array(
        [
            shapely.distance(
                shapely.Polygon(left), shapely.Polygon(pose.support.right_to_left(right))
            )
            for pose in poses
        ]
    )


def tilted(support: DoubleSupport, roll: float, pitch: float, height: float) -> FootPose:
    """As encoders that are a little off show a foot that stands."""
    flat = FootPose.of(support)
    turn = Rotation.from_euler("xy", [roll, pitch]).as_matrix()
    return FootPose(flat.rotation @ turn, flat.translation + np.array([0.0, 0.0, height]))


small = st.floats(-0.02, 0.02)


@given(support=supports, roll=small, pitch=small, height=small, support_phase=ONE)
def test_lifted_is_level_and_higher(
    support: DoubleSupport, roll: float, pitch: float, height: float, support_phase: SupportPhase
) -> None:
    pose = tilted(support, roll, pitch, height)
    begin, above = swing_segment((pose, lifted(pose, support_phase, 0.015)), support_phase)
    np.testing.assert_allclose(above.translation - begin.translation, [0, 0, 0.015], atol=1e-12)
    np.testing.assert_allclose(above.rotation[2], [0, 0, 1], atol=1e-12)
    assert above.support.dtheta == pytest.approx(begin.support.dtheta)


@given(
    begin=supports,
    end=supports,
    roll=small,
    aside=st.floats(0.0, 0.05),
    states=st.integers(4, 30),
    support_phase=ONE,
)
def test_a_way_begins_and_ends_slowly_where_it_should(
    begin: DoubleSupport,
    end: DoubleSupport,
    roll: float,
    aside: float,
    states: int,
    support_phase: SupportPhase,
) -> None:
    first, last = tilted(begin, roll, 0.0, 0.0), FootPose.of(end)
    way = interpolated_poses(first, last, support_phase, states, aside)
    assert len(way) == states + 1
    assert way[0] is first
    assert way[-1] is last
    inner = swing_segment(way, support_phase)
    steps = np.linalg.norm(np.diff([pose.translation for pose in inner], axis=0), axis=1)
    turns = np.array(
        [
            Rotation.from_matrix(a.rotation.T @ b.rotation).magnitude()
            for a, b in itertools.pairwise(inner)
        ]
    )
    # The first and last n-th of s^3 (10 - 15 s + 6 s^2) is below 10 / n^3.
    whole = np.linalg.norm(inner[-1].translation - inner[0].translation)
    limit = 10.0 / states**3
    assert max(steps[0], steps[-1]) <= limit * (whole + np.pi * aside) + 1e-12
    assert max(turns[0], turns[-1]) <= limit * turns.sum() + 1e-7
    # The fastest is 15 / 8 of the mean, and the bulge is at most as steep.
    assert steps.max() <= 15.0 / 8.0 * (whole + np.pi * aside) / states + 1e-12


@given(begin=supports, end=supports, support_phase=ONE)
def test_a_bulge_leads_away_from_the_foot_that_stands(
    begin: DoubleSupport, end: DoubleSupport, support_phase: SupportPhase
) -> None:
    straight, bulged = (
        swing_segment(
            interpolated_poses(FootPose.of(begin), FootPose.of(end), support_phase, 10, aside),
            support_phase,
        )
        for aside in (0.0, 0.03)
    )
    outward = 1.0 if support_phase is SupportPhase.RIGHT else -1.0
    away = [b.translation - a.translation for a, b in zip(straight, bulged, strict=True)]
    assert max(outward * way[1] for way in away) == pytest.approx(0.03)
    assert min(outward * way[1] for way in away) >= -1e-12
    np.testing.assert_allclose([way[[0, 2]] for way in away], 0.0, atol=1e-12)


@pytest.mark.parametrize("name", NAMES)
@given(
    begin=apart,
    end=apart,
    roll=st.floats(-0.01, 0.01),
    pitch=st.floats(-0.01, 0.01),
    support_phase=ONE,
)
@example(
    begin=DoubleSupport(0.0, -0.125, 0.125), end=DoubleSupport(0.0, -0.125, 0.0), roll=0.0,
    pitch=0.0, support_phase=SupportPhase.LEFT,
)  # fmt: skip
@example(
    begin=DoubleSupport(0.0, -0.125, 0.125), end=DoubleSupport(0.0, -0.125, 0.0), roll=-0.0078125,
    pitch=0.0, support_phase=SupportPhase.RIGHT,
)  # fmt: skip
def test_a_carried_foot_touches_nothing(
    name: str, begin: DoubleSupport, end: DoubleSupport, roll: float, pitch: float,
    support_phase: SupportPhase,
) -> None:  # fmt: skip
    robot = load_body(name).robot
    first, last = tilted(begin, roll, pitch, 0.0), FootPose.of(end)
    assume(gaps(robot, (first, last)).min() > SETTINGS.foot_clearance)
    poses = swing_path(robot, first, last, support_phase, SETTINGS)
    assert poses[0] is first
    assert poses[-1] is last
    low = corners(robot, poses, support_phase)[..., 2].min(axis=1)
    assert low.min() >= min(0.0, low[0]) - 1e-9
    # A foot that is led outward while it is lifted takes more states than a lift alone.
    above, below = (swing._above(robot, pose, support_phase, SETTINGS) for pose in (first, last))
    lifting = len(swing._led(first, above, support_phase, 0.0)) - 1
    lowering = len(swing._led(below, last, support_phase, 0.0)) - 1
    detect_lifted_foot = poses[lifting : len(poses) - lowering]
    lowest = min(swing_segment((first, last), support_phase), key=lambda pose: pose.translation[2])
    assert (
        corners(robot, detect_lifted_foot, support_phase)[..., 2].min()
        >= SETTINGS.step_lift + lowest.translation[2] - 1e-9
    )
    for pose in swing_segment(detect_lifted_foot, support_phase):
        np.testing.assert_allclose(pose.rotation[2], [0, 0, 1], atol=1e-9)
    allowed = min(SETTINGS.foot_clearance, gaps(robot, (first,))[0])
    up = vertical_states(SETTINGS.step_lift)
    # Going down it is above its place.
    assert gaps(robot, poses[:-up]).min() >= allowed - 5e-4
    moves = [
        np.linalg.norm(b.translation - a.translation)
        for a, b in itertools.pairwise(swing_segment(poses, support_phase))
    ]
    assert max(moves) <= STEP_WAY + 1e-12


@pytest.mark.parametrize("support_phase", [SupportPhase.LEFT, SupportPhase.RIGHT])
def test_round_the_other_foot(support_phase: SupportPhase) -> None:
    """From behind to before with the toes turned: straight on the feet would touch."""
    robot, clearance = load_body("nao").robot, SETTINGS.foot_clearance
    begin, end = DoubleSupport(-0.04, -0.112, 0.3), DoubleSupport(0.08, -0.112, -0.3)
    first, last = (FootPose.of(support) for support in (begin, end))
    if support_phase is SupportPhase.LEFT:
        first, last = mirrored(first), mirrored(last)
    assert gaps(robot, interpolated_poses(first, last, support_phase, 20)).min() < clearance
    assert gaps(robot, swing_path(robot, first, last, support_phase, SETTINGS)).min() >= clearance


def mirrored(pose: FootPose) -> FootPose:
    """Seen in a mirror, where left is right."""
    there = pose.inverse.support
    return FootPose.of(DoubleSupport(there.dx, -there.dy, -there.dtheta))


@pytest.mark.parametrize("support_phase", [SupportPhase.LEFT, SupportPhase.RIGHT])
def test_no_way_into_the_other_foot(support_phase: SupportPhase) -> None:
    inside = FootPose.of(DoubleSupport(0.0, -0.05, 0.0))
    with pytest.raises(NoSwingPathError, match="cannot be carried past the other one"):
        swing_path(load_body("nao").robot, FootPose.of(WIDE), inside, support_phase, SETTINGS)


def test_out_of_feet_that_stand_too_near() -> None:
    """A robot is where it is: then it must only not come nearer."""
    robot, strict = load_body("nao").robot, dataclasses.replace(SETTINGS, foot_clearance=0.03)
    begin = FootPose.of(DoubleSupport(0.0, -0.1, 0.0))
    poses = swing_path(robot, begin, FootPose.of(WIDE), SupportPhase.LEFT, strict)
    assert gaps(robot, poses).min() == pytest.approx(gaps(robot, (begin,))[0])


def test_a_higher_lift_takes_more_states() -> None:
    assert vertical_states(0.001) == 6
    assert vertical_states(0.1) == math.ceil(15.0 / 8.0 * 0.1 / STEP_WAY)
