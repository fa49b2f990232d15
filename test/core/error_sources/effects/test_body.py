"""Columns of masses and joints are what a model shows that lacks them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from numpy.typing import NDArray

from core.error_sources.altered import (
    bearing,
    body_states,
    heavier,
    shifted,
    with_angles,
    with_robot,
)
from core.error_sources.shows import assert_shows, shape, told
from shoecal_core.error_sources.body import driven_together
from shoecal_core.error_sources.effects.body import (
    Backlash,
    JointCompliance,
    JointOffset,
    LinkCom,
    Payload,
    TotalMass,
)
from shoecal_core.error_sources.effects.dynamics import Inertia
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.signals import AIR, COP, GRF, SIGNALS
from shoecal_core.model.robot import GRAVITY, Robot
from shoecal_core.samples.known_weight import KNOWN_MASS, WEIGHTED

FloatArray = NDArray[np.float64]
JOINTS = ("LHipYawPitch", "LKneePitch", "RAnkleRoll")


def test_pinocchio_tells_the_same_states(scene: Scene) -> None:
    """Those that tests of models compare with."""
    states = body_states(scene.samples.robot, scene.samples.angles[::50])
    for name in ("com", "rotation", "translation", "left_rotation", "left_translation"):
        usual = getattr(scene.samples.states, name)[::50]
        np.testing.assert_allclose(getattr(states, name), usual, atol=1e-9)


def in_proportion(robot: Robot, mass: float) -> Robot:
    """With a mass [kg] more, every link heavier by the same share."""
    model, factor = pin.Model(robot.model), 1.0 + mass / robot.mass
    for index, one in enumerate(robot.model.inertias):
        if one.mass > 0.0:
            model.inertias[index] = pin.Inertia(factor * one.mass, one.lever, one.inertia)
    return replace(robot, model=model, mass=robot.mass + mass)


def with_sheet(scene: Scene, name: str) -> Scene:
    """One channel has a gain by its data sheet."""
    shoe = scene.samples.shoe
    channels = tuple(
        replace(one, nominal_gain=1.0) if one.name == name else one for one in shoe.channels
    )
    return replace(scene, samples=replace(scene.samples, shoe=replace(shoe, channels=channels)))


def with_weight(scene: Scene, runs: tuple[int, ...]) -> Scene:
    """The robot bears the known weight in these runs."""
    samples = scene.samples
    tracks = tuple(
        replace(track, motion=WEIGHTED) if track.run in runs else track for track in samples.tracks
    )
    force = samples.force + GRAVITY * KNOWN_MASS * np.isin(samples.run, runs)
    return replace(scene, samples=replace(samples, tracks=tracks, force=force))


@pytest.mark.parametrize("mass", [0.1, -0.1])
def test_total_mass(scene: Scene, mass: float) -> None:
    """What was recorded is true; the model then has too little or too much in every link."""
    known = with_sheet(scene, scene.samples.shoe.names[5])
    after = with_robot(known, in_proportion(known.samples.robot, -mass))
    found = shape(known, TotalMass(), "all")
    assert_shows(known, after, told(found, mass))
    here = known.mask[:, 0]
    np.testing.assert_allclose(found.columns[0][here, 0], GRAVITY)
    assert not found.columns[0][:, 1:].any()


def test_a_kilogram_weighs_the_same_beside_a_known_weight(scene: Scene) -> None:
    found = shape(with_weight(scene, (3,)), TotalMass(), "all")
    np.testing.assert_allclose(found.columns[0][scene.mask[:, 0], 0], GRAVITY)


def test_nothing_tells_a_mass_from_gains_that_nothing_ties(scene: Scene) -> None:
    """All gains larger by a share are as a robot lighter by it."""
    heavy = TotalMass()
    assert not list(heavy.shapes(scene, ("all",)))
    assert not list(heavy.shapes(with_weight(scene, scene.samples.runs), ("all",)))
    assert list(heavy.shapes(with_weight(scene, scene.samples.runs[:1]), ("all",)))


def left_by_gains(scene: Scene) -> float:
    """Share of a wrong mass that no gains and offsets make up for, in usual noise."""
    std = np.full(len(SIGNALS), np.inf)
    std[GRF], std[COP], std[AIR] = 0.03, 3e-4, (0.03, 3e-3, 3e-3)
    count = 2 * len(scene.samples.shoe.names)
    laws = (scene.baseline[:count] / std).reshape(count, -1).T
    laws /= np.linalg.norm(laws, axis=0)
    mass = (shape(scene, TotalMass(), "all").columns[0] / std).ravel()
    rest = mass - laws @ np.linalg.lstsq(laws, mass, rcond=None)[0]
    return float(np.linalg.norm(rest) / np.linalg.norm(mass))


def test_gains_make_up_for_a_wrong_mass_but_not_beside_a_known_weight(scene: Scene) -> None:
    assert left_by_gains(with_sheet(scene, "left/front_left")) < 2e-3
    weighted = with_weight(scene, (3,))
    assert left_by_gains(bearing(weighted, scene.samples.cop)) > 2e-2


def heavy_links(scene: Scene) -> list[str]:
    """The root, a link of each leg, and one that neither leg carries."""
    return [place[0] for place in Payload().places(scene)]


@pytest.mark.parametrize("which", [0, 5, -1])
def test_payload(scene: Scene, which: int) -> None:
    """What was recorded is true; the model then lacks a mass."""
    link, mass = heavy_links(scene)[which], 0.02
    after = with_robot(scene, heavier(scene.samples.robot, link, -mass))
    assert_shows(scene, after, told(shape(scene, Payload(), link), mass))
    here = scene.mask[:, 0]
    assert (after.residuals[here, 0] > scene.residuals[here, 0]).all()


@pytest.mark.parametrize("which", [0, 5, -1])
@pytest.mark.parametrize("axis", range(3))
def test_link_com(scene: Scene, which: int, axis: int) -> None:
    link, far = heavy_links(scene)[which], 0.003
    after = with_robot(scene, shifted(scene.samples.robot, link, axis, -far))
    assert_shows(scene, after, told(shape(scene, LinkCom(), link), *(far * np.eye(3)[axis])))


@pytest.mark.parametrize("place", JOINTS)
def test_joint_offset(scene: Scene, place: str) -> None:
    """The recording is true; then an encoder shows more, and what hangs on its motor too."""
    robot, angle = scene.samples.robot, 0.003
    change = np.zeros_like(scene.samples.angles)
    for joint, ratio in driven_together(robot, robot.joint(place)):
        change[:, joint] = ratio * angle
    found = shape(scene, JointOffset(), place)
    # A median of many samples moves nearly, not wholly, as they do.
    assert_shows(scene, with_angles(scene, change), told(found, angle), within=0.15)


def test_a_motor_s_follower_has_no_encoder_of_its_own(scene: Scene) -> None:
    robot = scene.samples.robot
    following = {robot.joint_names[one.joint] for one in robot.shared}
    assert following
    assert following.isdisjoint(place[0] for place in JointOffset().places(scene))


def test_an_ankle_holds_the_floor_s_force_against_the_foot(scene: Scene) -> None:
    """By hand: about an ankle's roll axis, the motor balances all that acts on the foot."""
    samples = scene.samples
    robot = samples.robot
    foot = robot.feet[0]
    joint = foot.joint - 2
    assert robot.joint_names[joint] == "LAnkleRoll"
    index = int(np.flatnonzero(samples.both)[0])
    force, about_x, about_y = scene.foot_wrenches[index, 0]
    # The ankle's origin in the sole's frame; x is the axis.
    ankle = foot.placement.inverse().translation
    np.testing.assert_allclose(foot.placement.rotation, np.eye(3), atol=1e-6)
    inertia = robot.model.inertias[foot.joint]
    weight_at = ankle + inertia.lever
    by_floor = about_x - ankle[1] * force
    by_weight = -GRAVITY * inertia.mass * (weight_at[1] - ankle[1])
    assert scene.links.torque[index, joint] == pytest.approx(-(by_floor + by_weight), abs=2e-3)
    assert about_y != 0.0


@pytest.mark.parametrize("place", [*JOINTS[1:], "all"])
def test_joint_compliance(scene: Scene, place: str) -> None:
    """Under a motor's torque the link stays behind: the encoder, which is before, shows more."""
    robot, compliance = scene.samples.robot, 1e-3
    change = np.zeros_like(scene.samples.angles)
    joints = robot.moved if place == "all" else [robot.joint(place)]
    change[:, joints] = compliance * scene.torque[:, joints]
    found = shape(scene, JointCompliance(), place)
    assert_shows(scene, with_angles(scene, change), told(found, compliance), within=0.15)


@pytest.mark.parametrize("place", [*JOINTS[1:], "all"])
def test_backlash(scene: Scene, place: str) -> None:
    """Pushed by its motor, a link lies behind by half the play."""
    robot, play = scene.samples.robot, 1e-3
    change = np.zeros_like(scene.samples.angles)
    joints = robot.moved if place == "all" else [robot.joint(place)]
    change[:, joints] = 0.5 * play * np.sign(scene.torque[:, joints])
    found = shape(scene, Backlash(), place)
    assert_shows(scene, with_angles(scene, change), told(found, play), within=0.3)


def test_inertia_is_the_zero_moment_point_s_way_from_the_com(scene: Scene) -> None:
    samples = scene.samples
    assert not scene.fast
    assert not list(Inertia().shapes(scene, ()))
    acceleration = 0.2 * np.sin(3.0 * samples.time)[:, None] * np.array([1.0, -0.5, 0.3])
    height = samples.states.com[np.arange(len(samples.frame)), samples.frame, 2]
    fast = replace(scene, samples=replace(samples, acceleration=acceleration))
    assert fast.fast
    wanted = samples.spin - height[:, None] * acceleration[:, :2] / GRAVITY
    found = shape(fast, Inertia())
    np.testing.assert_allclose(found.columns[0][:, COP], wanted)
    force = samples.robot.mass * acceleration[:, 2]
    np.testing.assert_allclose(found.columns[0][:, 0], force)
