"""Every motion of the menu, of every robot, as phases that are what they say."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
import shapely

from core.planning.bodies import NAMES, load_body
from core.planning.motions import SETTINGS, SUPPORTS, motion_of, planner_of
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError
from shoecal_core.planning.checking.body_track import BodyTrack, track
from shoecal_core.planning.motion import Motion, Phase
from shoecal_core.planning.motion_catalogue import MOTION_KINDS, motion_kind
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.posture import UnreachableError
from shoecal_core.planning.support_phase import SupportPhase

CASES = [(name, motion) for name in NAMES for motion in MOTION_KINDS]
UNLOADING = {"unload_left": SupportPhase.RIGHT, "unload_right": SupportPhase.LEFT}


@cache
def planned(name: str, motion: str) -> Motion:
    if motion == "landmarks":
        return motion_of(name)
    return planner_of(name).plan(SUPPORTS[0], motion)


@cache
def body_of(name: str, motion: str) -> BodyTrack:
    return track(load_body(name).robot, planned(name, motion).positions)


def samples(motion: Motion, phase: Phase) -> slice:
    begin, end = np.searchsorted(motion.time, [phase.begin, phase.end])
    return slice(int(begin), int(end) + 1)


@pytest.mark.parametrize(("name", "motion"), CASES)
def test_phases_follow_each_other_from_rest_to_rest(name: str, motion: str) -> None:
    found = planned(name, motion)
    assert found.name == motion
    assert found.phases[0].begin == 0.0
    assert found.phases[-1].end == found.duration
    for before, after in zip(found.phases[:-1], found.phases[1:], strict=True):
        assert before.end == after.begin
        np.testing.assert_array_equal(
            before.foot_poses[1].parameters, after.foot_poses[0].parameters
        )
        border = np.flatnonzero(found.time == after.begin)
        assert len(border) == 1
        np.testing.assert_allclose(found.velocities[border], 0.0, atol=1e-9)
    # It ends on the feet on which it began.
    first, last = found.phases[0].foot_poses[0], found.phases[-1].foot_poses[1]
    np.testing.assert_array_equal(first.parameters, last.parameters)


@pytest.mark.parametrize(("name", "motion"), CASES)
def test_the_cop_stays_on_the_feet_that_carry(name: str, motion: str) -> None:
    found, robot, body = planned(name, motion), load_body(name).robot, body_of(name, motion)
    for phase in found.phases:
        at = samples(found, phase)
        places = body.com[at, :2]
        if phase.support_phase is SupportPhase.RIGHT:
            away = body.com[at] - body.right_translation[at]
            places = np.einsum("tji,tj->ti", body.right_rotation[at], away)[:, :2]
            polygon = shapely.Polygon(robot.feet[1].sensing_polygon)
        else:
            polygon = phase.support_phase.polygon(robot, phase.foot_poses[0])
        assert np.all(shapely.contains_xy(polygon.buffer(-0.003), *places.T))


@pytest.mark.parametrize(("name", "motion"), [(n, m) for n in NAMES for m in UNLOADING])
def test_an_unloaded_foot_is_lifted_held_and_put_down(name: str, motion: str) -> None:
    found, body = planned(name, motion), body_of(name, motion)
    assert [phase.name for phase in found.phases] == ["shift", "lift", "lower", "back"]
    both, one = SupportPhase.BOTH, UNLOADING[motion]
    assert [phase.support_phase for phase in found.phases] == [both, one, one, both]
    up = body.right_translation[:, 2] * (1.0 if one is SupportPhase.LEFT else -1.0)
    _, lift, lower, _ = (samples(found, phase) for phase in found.phases)
    assert up.max() == pytest.approx(SETTINGS.lift, abs=2e-4)
    # Between two planned states a little more or less.
    assert np.all(np.diff(up[lift]) > -5e-5)
    assert np.all(np.diff(up[lower]) < 5e-5)
    still = np.abs(found.velocities[lift]).max(axis=1) == 0.0
    assert np.sum(still) >= SETTINGS.unloaded_time * SETTINGS.sample_rate
    back = np.abs(body.com[-1, :2] - body.com[0, :2])
    assert back.max() < SETTINGS.landmark_radius


@pytest.mark.parametrize("name", NAMES)
def test_holding_stands_still_at_every_landmark(name: str) -> None:
    found, marked = planned(name, "hold"), planned(name, "landmarks")
    np.testing.assert_allclose(found.path.targets, marked.path.targets[1:], atol=1e-9)
    for phase in found.phases:
        at = samples(found, phase)
        still = np.abs(found.velocities[at]).max(axis=1) < 1e-9
        assert np.sum(still) >= SETTINGS.dwell_time * SETTINGS.sample_rate


def torso(name: str, motion: Motion) -> FloatArray:
    """(T, 3) along the floor the direction of its upward axis, and its height [m]."""
    robot = load_body(name).robot
    data, foot = robot.model.createData(), robot.feet[0]
    rows = []
    for angles in motion.positions:
        free = np.concatenate([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], angles])
        pin.forwardKinematics(robot.model, data, free)
        sole = data.oMi[foot.joint] * foot.placement
        rows.append([*sole.rotation.T[:2, 2], sole.inverse().translation[2]])
    return np.array(rows)


def test_a_torso_that_may_lean_less_leans_less() -> None:
    freely = planned("nao", "landmarks")
    robot = dataclasses.replace(load_body("nao").robot, tilt_max=0.2)
    upright = Planner(robot, SETTINGS).plan(SUPPORTS[0])
    most = [np.linalg.norm(torso("nao", one)[:, :2], axis=1).max() for one in (freely, upright)]
    assert 0.2 < most[0] <= np.sin(0.4)
    assert most[1] <= np.sin(0.2)
    # Landmarks that would ask for more have been moved in, and are reached.
    assert np.all(upright.path.nearest < SETTINGS.landmark_radius)


@pytest.mark.parametrize("name", NAMES)
def test_the_torso_leans_each_way_while_the_cop_stays(name: str) -> None:
    found = planned(name, "torso_tilt")
    lean = torso(name, found)[:, :2]
    for side in (lean.max(axis=0), -lean.min(axis=0)):
        np.testing.assert_allclose(side, SETTINGS.tilt, atol=0.015)
    np.testing.assert_allclose(lean[-1], 0.0, atol=0.015)
    # Each time it ends where it was; on the way it gives way a little.
    assert np.all(found.path.nearest < SETTINGS.landmark_radius)
    assert np.abs(found.cop - found.cop[0]).max() < 0.02


@pytest.mark.parametrize("name", NAMES)
def test_the_torso_goes_round_lower(name: str) -> None:
    found, marked = planned(name, "torso_height"), planned(name, "landmarks")
    height = torso(name, found)[:, 2]
    assert height[0] - height.min() > 0.9 * SETTINGS.sink
    assert height[-1] == pytest.approx(height[0], abs=0.005)
    ring, wide = (shapely.convex_hull(shapely.MultiPoint(one.cop)) for one in (found, marked))
    assert ring.area > 0.5 * wide.area


def test_motors_too_weak_for_one_foot() -> None:
    """What a robot cannot do ends in one line that says so."""
    robot = load_body("nao").robot
    weak = dataclasses.replace(SETTINGS, torque_share=0.45)
    planner = Planner(robot, weak)
    planner.stance(SUPPORTS[0])
    with pytest.raises(UnreachableError, match="cannot stand on its right foot alone") as caught:
        planner.plan(SUPPORTS[0], "unload_left")
    assert "\n" not in str(caught.value)


def test_what_is_not_on_the_menu() -> None:
    with pytest.raises(NameNotFoundError, match=r"motion named 'dance' .*unload_left"):
        motion_kind("dance")
    for name, kind in MOTION_KINDS.items():
        assert motion_kind(name) is kind
        assert kind.doc
    assert [name for name, kind in MOTION_KINDS.items() if kind.streams] == [
        "landmarks",
        "reversed",
    ]
