"""Columns of masses and joints are what a model shows that lacks them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

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
    Inertia,
    JointCompliance,
    JointFriction,
    JointOffset,
    LinkCom,
    Payload,
    TotalMass,
)
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import AIR, COP, GRF, SIGNALS
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.known_weight import KNOWN_MASS, WEIGHTED
from shoecal_core.samples.samples import TURNED_BACK

JOINTS = ("LHipYawPitch", "LKneePitch", "RAnkleRoll")


def test_pinocchio_tells_the_same_states(signal_model: SignalModel) -> None:
    """Those that tests of models compare with."""
    states = body_states(signal_model.samples.robot, signal_model.samples.angles[::50])
    for name in ("com", "rotation", "translation", "left_rotation", "left_translation"):
        usual = getattr(signal_model.samples.states, name)[::50]
        np.testing.assert_allclose(getattr(states, name), usual, atol=1e-9)


def in_proportion(robot: Robot, mass: float) -> Robot:
    """With a mass [kg] more, every link heavier by the same share."""
    model, factor = pin.Model(robot.model), 1.0 + mass / robot.mass
    for index, one in enumerate(robot.model.inertias):
        if one.mass > 0.0:
            model.inertias[index] = pin.Inertia(factor * one.mass, one.lever, one.inertia)
    return replace(robot, model=model, mass=robot.mass + mass)


def with_sheet(signal_model: SignalModel, name: str) -> SignalModel:
    """One channel has a gain by its data sheet."""
    shoe = signal_model.samples.shoe
    channels = tuple(
        replace(one, nominal_gain=1.0) if one.name == name else one for one in shoe.channels
    )
    return replace(
        signal_model, samples=replace(signal_model.samples, shoe=replace(shoe, channels=channels))
    )


def with_weight(signal_model: SignalModel, runs: tuple[int, ...]) -> SignalModel:
    """The robot bears the known weight in these runs."""
    samples = signal_model.samples
    tracks = tuple(
        replace(track, motion=WEIGHTED) if track.run in runs else track for track in samples.tracks
    )
    force = samples.force + GRAVITY * KNOWN_MASS * np.isin(samples.run, runs)
    return replace(signal_model, samples=replace(samples, tracks=tracks, force=force))


@pytest.mark.parametrize("mass", [0.1, -0.1])
def test_total_mass(signal_model: SignalModel, mass: float) -> None:
    """What was recorded is true; the model then has too little or too much in every link."""
    known = with_sheet(signal_model, signal_model.samples.shoe.names[5])
    after = with_robot(known, in_proportion(known.samples.robot, -mass))
    found = shape(known, TotalMass(), "all")
    assert_shows(known, after, told(found, mass))
    here = known.mask[:, 0]
    np.testing.assert_allclose(found.columns[0][here, 0], GRAVITY)
    assert not found.columns[0][:, 1:].any()


def test_a_kilogram_weighs_the_same_beside_a_known_weight(signal_model: SignalModel) -> None:
    found = shape(with_weight(signal_model, (3,)), TotalMass(), "all")
    np.testing.assert_allclose(found.columns[0][signal_model.mask[:, 0], 0], GRAVITY)


def test_nothing_tells_a_mass_from_gains_that_nothing_ties(signal_model: SignalModel) -> None:
    """All gains larger by a share are as a robot lighter by it."""
    heavy = TotalMass()
    assert not list(heavy.shapes(signal_model, ("all",)))
    assert not list(heavy.shapes(with_weight(signal_model, signal_model.samples.runs), ("all",)))
    assert list(heavy.shapes(with_weight(signal_model, signal_model.samples.runs[:1]), ("all",)))


def left_by_gains(signal_model: SignalModel) -> float:
    """Share of a wrong mass that no gains and offsets make up for, in usual noise."""
    std = np.full(len(SIGNALS), np.inf)
    std[GRF], std[COP], std[AIR] = 0.03, 3e-4, (0.03, 3e-3, 3e-3)
    count = 2 * len(signal_model.samples.shoe.names)
    laws = (signal_model.baseline[:count] / std).reshape(count, -1).T
    laws /= np.linalg.norm(laws, axis=0)
    mass = (shape(signal_model, TotalMass(), "all").columns[0] / std).ravel()
    rest = mass - laws @ np.linalg.lstsq(laws, mass, rcond=None)[0]
    return float(np.linalg.norm(rest) / np.linalg.norm(mass))


def test_gains_make_up_for_a_wrong_mass_but_not_beside_a_known_weight(
    signal_model: SignalModel,
) -> None:
    assert left_by_gains(with_sheet(signal_model, "left/front_left")) < 2e-3
    weighted = with_weight(signal_model, (3,))
    assert left_by_gains(bearing(weighted, signal_model.samples.cop)) > 2e-2


def heavy_links(signal_model: SignalModel) -> list[str]:
    """The root, a link of each leg, and one that neither leg carries."""
    return [place[0] for place in Payload().places(signal_model)]


@pytest.mark.parametrize("which", [0, 5, -1])
def test_payload(signal_model: SignalModel, which: int) -> None:
    """What was recorded is true; the model then lacks a mass."""
    link, mass = heavy_links(signal_model)[which], 0.02
    after = with_robot(signal_model, heavier(signal_model.samples.robot, link, -mass))
    assert_shows(signal_model, after, told(shape(signal_model, Payload(), link), mass))
    here = signal_model.mask[:, 0]
    assert (after.residuals[here, 0] > signal_model.residuals[here, 0]).all()


@pytest.mark.parametrize("which", [0, 5, -1])
@pytest.mark.parametrize("axis", range(3))
def test_link_com(signal_model: SignalModel, which: int, axis: int) -> None:
    link, far = heavy_links(signal_model)[which], 0.003
    after = with_robot(signal_model, shifted(signal_model.samples.robot, link, axis, -far))
    assert_shows(
        signal_model, after, told(shape(signal_model, LinkCom(), link), *(far * np.eye(3)[axis]))
    )


@pytest.mark.parametrize("place", JOINTS)
def test_joint_offset(signal_model: SignalModel, place: str) -> None:
    """The recording is true; then an encoder shows more, and what hangs on its motor too."""
    robot, angle = signal_model.samples.robot, 0.003
    change = np.zeros_like(signal_model.samples.angles)
    for joint, ratio in driven_together(robot, robot.joint(place)):
        change[:, joint] = ratio * angle
    found = shape(signal_model, JointOffset(), place)
    # A median of many samples moves nearly, not wholly, as they do.
    assert_shows(signal_model, with_angles(signal_model, change), told(found, angle), within=0.15)


def test_a_motor_s_follower_has_no_encoder_of_its_own(signal_model: SignalModel) -> None:
    robot = signal_model.samples.robot
    following = {robot.joint_names[one.joint] for one in robot.shared}
    assert following
    assert following.isdisjoint(place[0] for place in JointOffset().places(signal_model))


def test_an_ankle_holds_the_floor_s_force_against_the_foot(signal_model: SignalModel) -> None:
    """By hand: about an ankle's roll axis, the motor balances all that acts on the foot."""
    samples = signal_model.samples
    robot = samples.robot
    foot = robot.feet[0]
    joint = foot.joint - 2
    assert robot.joint_names[joint] == "LAnkleRoll"
    index = int(np.flatnonzero(samples.both)[0])
    force, about_x, about_y = signal_model.foot_wrenches[index, 0]
    # The ankle's origin in the sole's frame; x is the axis.
    ankle = foot.placement.inverse().translation
    np.testing.assert_allclose(foot.placement.rotation, np.eye(3), atol=1e-6)
    inertia = robot.model.inertias[foot.joint]
    weight_at = ankle + inertia.lever
    by_floor = about_x - ankle[1] * force
    by_weight = -GRAVITY * inertia.mass * (weight_at[1] - ankle[1])
    assert signal_model.links.torque[index, joint] == pytest.approx(
        -(by_floor + by_weight), abs=2e-3
    )
    assert about_y != 0.0


def test_soles_on_the_floor_stay_whatever_joints_give(signal_model: SignalModel) -> None:
    """And joints give as they would otherwise in all ways that leave the soles where they are."""
    samples = signal_model.samples
    legs, both = samples.robot.moved, samples.both
    given = np.zeros_like(samples.angles)
    given[:, legs] = np.random.default_rng(0).normal(0.0, 0.01, (len(given), len(legs)))
    held = signal_model.held(given)
    np.testing.assert_array_equal(held[~both], given[~both])
    closure = signal_model.jacobians.closure[both][..., legs]
    assert np.abs(np.einsum("tkm,tm->tk", closure, given[both][:, legs])).max() > 0.01
    np.testing.assert_allclose(
        np.einsum("tkm,tm->tk", closure, held[both][:, legs]), 0.0, atol=1e-6
    )
    np.testing.assert_allclose(signal_model.held(held), held, atol=1e-6)
    free = np.linalg.svd(closure)[2][:, 6:]
    np.testing.assert_allclose(
        np.einsum("tkm,tm->tk", free, held[both][:, legs]),
        np.einsum("tkm,tm->tk", free, given[both][:, legs]),
        atol=1e-6,
    )


def test_walking_soles_may_tip(signal_model: SignalModel) -> None:
    """Joints that give then keep soles from moving along the floor alone."""
    samples = signal_model.samples
    walking = replace(signal_model, samples=replace(samples, walks=np.ones_like(samples.walks)))
    given = np.full_like(samples.angles, 0.01)
    given[:, samples.robot.moved[::2]] *= -1.0
    closure = walking.jacobians.closure[samples.both]
    moved = np.einsum("tkm,tm->tk", closure, walking.held(given)[samples.both])
    before = np.einsum("tkm,tm->tk", closure, given[samples.both])
    assert np.abs(moved[:, (0, 1, 5)]).max() < 1e-6
    assert np.abs(before[:, (0, 1, 5)]).max() > 1e-3
    assert np.abs(moved[:, (2, 3, 4)]).max() > 1e-3


@pytest.mark.parametrize("place", [*JOINTS[1:], "all"])
def test_joint_compliance(signal_model: SignalModel, place: str) -> None:
    """Under a motor's torque the link stays behind: the encoder, which is before, shows more."""
    robot, compliance = signal_model.samples.robot, 1e-3
    change = np.zeros_like(signal_model.samples.angles)
    joints = robot.moved if place == "all" else [robot.joint(place)]
    change[:, joints] = compliance * signal_model.torque[:, joints]
    held, free = JointCompliance().shapes(signal_model, (place,))
    for given, found in ((change, free), (signal_model.held(change), held)):
        assert_shows(
            signal_model, with_angles(signal_model, given), told(found, compliance), within=0.15
        )


@pytest.mark.parametrize("place", [*JOINTS[1:], "all"])
def test_backlash(signal_model: SignalModel, place: str) -> None:
    """Pushed by its motor, a link lies behind by half the play."""
    robot, play = signal_model.samples.robot, 1e-3
    change = np.zeros_like(signal_model.samples.angles)
    joints = robot.moved if place == "all" else [robot.joint(place)]
    change[:, joints] = 0.5 * play * np.sign(signal_model.torque[:, joints])
    held, _, free, *_ = Backlash().shapes(signal_model, (place,))
    for given, found in ((change, free), (signal_model.held(change), held)):
        shown = with_angles(signal_model, given)
        assert_shows(signal_model, shown, told(found, play), within=0.35)


@pytest.mark.parametrize("place", [*JOINTS[1:], "all"])
def test_friction_keeps_a_link_behind_by_the_way_that_it_came(
    signal_model: SignalModel, place: str
) -> None:
    """From one side to the other while the joint turns back; at rest it stays where it is.

    Where both feet stick, other joints give way.
    """
    samples, lag = signal_model.samples, 1e-3
    sides = []
    for track in samples.tracks:
        side = np.zeros_like(track.angles)
        for row, turned in enumerate(np.diff(track.angles, axis=0), 1):
            side[row] = np.clip(side[row - 1] + turned / TURNED_BACK, -0.5, 0.5)
        sides.append(track.mean(side))
    behind = np.concatenate(sides)
    joints = samples.robot.moved if place == "all" else [samples.robot.joint(place)]
    change = np.zeros_like(behind)
    change[:, joints] = lag * behind[:, joints]
    change = signal_model.held(change)
    found = shape(signal_model, JointFriction(), place)
    assert_shows(signal_model, with_angles(signal_model, change), told(found, lag), within=0.25)
    # A robot's friction is what play looks like that is dragged.
    *_, dragged = Backlash().shapes(signal_model, (place,))
    np.testing.assert_array_equal(dragged.columns, found.columns)


def test_inertia_is_the_zero_moment_point_s_way_from_the_com(signal_model: SignalModel) -> None:
    samples = signal_model.samples
    assert not signal_model.fast
    assert not list(Inertia().shapes(signal_model, ()))
    acceleration = 0.2 * np.sin(3.0 * samples.time)[:, None] * np.array([1.0, -0.5, 0.3])
    height = samples.states.com[np.arange(len(samples.frame)), samples.frame, 2]
    fast = replace(signal_model, samples=replace(samples, acceleration=acceleration))
    assert fast.fast
    wanted = samples.spin - height[:, None] * acceleration[:, :2] / GRAVITY
    found = shape(fast, Inertia())
    np.testing.assert_allclose(found.columns[0][:, COP], wanted)
    force = samples.robot.mass * acceleration[:, 2]
    np.testing.assert_allclose(found.columns[0][:, 0], force)
