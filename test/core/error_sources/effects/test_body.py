"""Columns of masses and joints are what a model shows that lacks them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from core.error_sources.altered import body_states, heavier, shifted, with_angles, with_robot
from core.error_sources.shows import assert_shows, shape, told
from shoecal_core.error_sources.body import driven_together
from shoecal_core.error_sources.effects.body import (
    Backlash,
    JointCompliance,
    JointOffset,
    LinkCom,
    Payload,
)
from shoecal_core.error_sources.effects.dynamics import Inertia
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.signals import COP
from shoecal_core.model.robot import GRAVITY

FloatArray = NDArray[np.float64]
JOINTS = ("LHipYawPitch", "LKneePitch", "RAnkleRoll")


def test_pinocchio_tells_the_same_states(scene: Scene) -> None:
    """Those that tests of models compare with."""
    states = body_states(scene.samples.robot, scene.samples.angles[::50])
    for name in ("com", "rotation", "translation", "left_rotation", "left_translation"):
        usual = getattr(scene.samples.states, name)[::50]
        np.testing.assert_allclose(getattr(states, name), usual, atol=1e-9)


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
