"""Columns of what lies below the ankles are what soles, floors and steps really do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.error_sources.altered import (
    askew,
    bearing,
    below,
    body_states,
    stance_com,
    turning,
    with_robot,
)
from core.error_sources.shows import assert_shows, shape, told
from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources import body
from shoecal_core.error_sources.effects.contact import FloorTilt, FootPlacement, Slip, SoftGround
from shoecal_core.error_sources.signal_model import SignalModel, make_signal_model
from shoecal_core.error_sources.signals import CLOSURE, COP
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.samples import Samples
from shoecal_core.shoe.shoe import FEET
from shoecal_core.shoe.wrench import to_left


@pytest.mark.parametrize("foot", FEET)
@pytest.mark.parametrize("axis", range(3))
def test_foot_placement(signal_model: SignalModel, foot: str, axis: int) -> None:
    """What was recorded is true; the model's soles then sit elsewhere by the inverse."""
    size = (0.003, 0.003, 0.01)[axis] * np.eye(3)[axis]
    robot = askew(signal_model.samples.robot, FEET.index(foot), *(-size))
    found = shape(signal_model, FootPlacement(), foot)
    assert_shows(signal_model, with_robot(signal_model, robot), told(found, *size))


def test_foot_placement_of_a_robot_that_walks(signal_model: SignalModel) -> None:
    """The CoP is the zero-moment point, not below the CoM: the sole moves as below that."""
    samples = signal_model.samples
    walks = replace(samples, cop=samples.cop + np.array([0.05, -0.03]))
    walking = make_signal_model(walks, signal_model.parameters, DiagnosisSettings())
    told = (signal_model.mask & walking.mask)[:, COP]
    one, other = (
        shape(there, FootPlacement(), "left").columns for there in (signal_model, walking)
    )
    np.testing.assert_allclose(other[:, :, COP][:, told], one[:, :, COP][:, told], atol=0.1)


@pytest.mark.parametrize(("about_x", "about_y"), [(0.004, 0.0), (0.0, 0.004), (-0.002, 0.003)])
def test_floor_tilt(signal_model: SignalModel, about_x: float, about_y: float) -> None:
    """Gravity turned against the floor, below a body that stands on it as before."""
    samples = signal_model.samples
    (floor,) = turning(np.array([[about_x, about_y, 0.0]]))
    upwards = np.tile(floor.T @ [0.0, 0.0, 1.0], (len(samples.run), 1))
    flat = np.tile([0.0, 0.0, 1.0], (len(samples.run), 1))
    before, after = (leaning(signal_model, up, upwards_in_right=None) for up in (flat, upwards))
    assert_shows(before, after, told(shape(signal_model, FloorTilt()), about_x, about_y), 0.05)


def test_a_floor_that_rises_to_the_left_takes_the_cop_to_the_right(
    signal_model: SignalModel,
) -> None:
    columns = shape(signal_model, FloorTilt()).columns
    height = signal_model.samples.states.com[:, 0, 2]
    both = signal_model.samples.both
    one, other = (both & signal_model.mask[:, signal] for signal in (2, 1))
    np.testing.assert_allclose(columns[0][one, 2], -height[one])
    np.testing.assert_allclose(columns[1][other, 1], height[other])


def leaning(
    signal_model: SignalModel, upwards: FloatArray, upwards_in_right: FloatArray | None
) -> SignalModel:
    """Soles that lean: the CoP lies below the CoM along upwards (T, 3), and an IMU feels it.

    Args:
        upwards: in the left sole's frame. upwards_in_right: in the right one's, where it does
            not follow from the joints.
    """
    samples = signal_model.samples
    right = upwards_in_right
    if right is None:
        right = np.einsum("tji,tj->ti", samples.states.rotation, upwards)
    stance = np.where((samples.frame == 0)[:, None], upwards, right)
    seen = np.where(
        (samples.frame == 0)[:, None],
        upwards,
        np.einsum("tij,tj->ti", samples.states.rotation, right),
    )
    up = np.einsum("tij,tj->ti", samples.states.left_rotation, seen)
    moved = bearing(signal_model, below(stance_com(samples), stance))
    return replace(moved, samples=replace(moved.samples, up=up))


def level(signal_model: SignalModel) -> SignalModel:
    """With upwards along both soles' z axes."""
    flat = np.tile([0.0, 0.0, 1.0], (len(signal_model.samples.run), 1))
    return leaning(signal_model, flat, flat)


@pytest.mark.parametrize("place", [*FEET, "all"])
def test_soft_ground(signal_model: SignalModel, place: str) -> None:
    """Each shoe sinks at the side on which it presses, about the middle of its outline."""
    samples, compliance = signal_model.samples, 1e-3
    before = level(bearing(signal_model, samples.cop))
    turn = np.zeros((len(samples.run), 2, 3))
    for foot in (0, 1):
        if place not in (FEET[foot], "all"):
            continue
        force, about_x, about_y = before.foot_wrenches[:, foot].T
        x, y = samples.robot.feet[foot].outline.mean(axis=0)
        ahead, aside = -about_y - x * force, about_x - y * force
        # Pressed ahead it turns forward, about +y; pressed to its left it turns about -x.
        turn[:, foot] = compliance * np.stack((-aside, ahead, 0.0 * force), axis=1)
    turn[~samples.loaded] = 0.0
    left, right = turning(turn[:, 0]), turning(turn[:, 1])
    told_by_joints = left.transpose(0, 2, 1) @ samples.states.rotation @ right
    states = replace(samples.states, rotation=told_by_joints)
    leant = replace(before, samples=replace(before.samples, states=states))
    up = [one.transpose(0, 2, 1) @ [0.0, 0.0, 1.0] for one in (left, right)]
    after = leaning(leant, up[0], up[1])
    found = shape(before, SoftGround(), place)
    assert_shows(before, after, told(found, compliance), within=0.05)


@pytest.mark.parametrize("foot", FEET)
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("share", [0.2, 0.8])
def test_slip(signal_model: SignalModel, foot: str, axis: int, share: float) -> None:
    """After a while the joints tell that a foot stands elsewhere, and weight is shared anew."""
    samples = signal_model.samples
    here = samples.run == 1
    onset = float(np.quantile(samples.time[here], share))
    size = (0.004, 0.004, 0.04)[axis]
    moved = slipped(signal_model, foot, size * np.eye(3)[axis], here & (samples.time > onset))
    before = bearing(signal_model, samples.cop)
    after = bearing(
        replace(signal_model, samples=moved), moved.cop, true_columns(signal_model, moved)
    )
    (found,) = (one for one in Slip().shapes(after, (foot,)) if nearly(one.onset, onset, one.run))
    assert found.fixed == {"time": found.onset}
    foretold = told(found, *(size * np.eye(3)[axis]))
    change = after.residuals - before.residuals
    for part in (COP, CLOSURE):
        off, most = (np.linalg.norm(one[here][:, part]) for one in (change - foretold, change))
        # A median of two places is as sure as the encoders are.
        assert off < max(0.1 * most, 1.5e-4 * np.sqrt(here.sum()))


def nearly(found: float | None, onset: float, run: int | None) -> bool:
    return run == 1 and found is not None and abs(found - onset) < 0.3


def slipped(signal_model: SignalModel, foot: str, move: FloatArray, later: BoolArray) -> Samples:
    """The legs follow a foot that moves by (3,) dx, dy, dtheta in its own frame."""
    samples = signal_model.samples
    states = samples.states
    step = turning(np.array([[0.0, 0.0, move[2]]]))[0]
    far = np.array([move[0], move[1], 0.0])
    rotation, translation = states.rotation.copy(), states.translation.copy()
    if foot == "right":
        translation[later] += (rotation @ far)[later]
        rotation[later] = (rotation @ step)[later]
    else:
        translation[later] = ((translation - far) @ step)[later]
        rotation[later] = (step.T @ rotation)[later]
    wanted = body.closure(replace(states, rotation=rotation, translation=translation))
    angles, found = samples.angles, states
    for _ in range(3):
        missing = wanted - body.closure(found)
        angles = angles + np.einsum(
            "tmi,ti->tm", np.linalg.pinv(signal_model.jacobians.closure), missing
        )
        found = body_states(samples.robot, angles)
    np.testing.assert_allclose(body.closure(found), wanted, atol=1e-5)
    cop = np.where(samples.frame[:, None] == 0, found.com[:, 0, :2], found.com[:, 1, :2])
    return replace(samples, angles=angles, states=found, cop=cop)


def true_columns(signal_model: SignalModel, moved: Samples) -> FloatArray:
    """(T, n, 3) of all channels in the stance's frame, the right foot where it stands by then."""
    columns = signal_model.per_sample.copy()
    right = signal_model.wiring.foot == 1
    states = moved.states
    for index in np.flatnonzero(moved.both):
        dx, dy, _ = map(float, states.translation[index])
        stands = DoubleSupport(dx, dy, float(states.yaw[index]))
        columns[index, right] = signal_model.wiring.columns[right] @ to_left(stands).T
    return columns
