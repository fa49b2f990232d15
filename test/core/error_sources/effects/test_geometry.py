"""Columns of places and mixtures are what a wrong shoe file, or mixed readings, really show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from core.error_sources.altered import with_forces
from core.error_sources.shows import assert_shows, shape, told
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.effects.geometry import (
    CellPosition,
    Crosstalk,
    OffAxisLoad,
    SwappedCells,
    sideways,
)
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import PARITY


@pytest.mark.parametrize("cell", ["left/rear_left", "right/front_left", "right/rear_right"])
def test_cell_position(signal_model: SignalModel, cell: str) -> None:
    """The recording is true by the shoe file; the file is then moved the other way."""
    assert max(abs(support.dtheta) for support in signal_model.supports) > 0.2
    x, y = 0.002, -0.003
    columns = signal_model.wiring.columns.copy()
    columns[signal_model.samples.shoe.names.index(cell)] -= 0.0, y, -x
    after = replace(signal_model, wiring=replace(signal_model.wiring, columns=columns))
    assert_shows(signal_model, after, told(shape(signal_model, CellPosition(), cell), x, y))


@pytest.mark.parametrize(
    ("receiver", "donor"),
    [("left/front_left", "left/rear_right"), ("right/rear_left", "right/front_left")],
)
def test_crosstalk(signal_model: SignalModel, receiver: str, donor: str) -> None:
    to, of = (signal_model.samples.shoe.names.index(name) for name in (receiver, donor))

    def mixed(_: object, force: FloatArray) -> FloatArray:
        shown = force.copy()
        shown[:, to] += 0.05 * force[:, of]
        return shown

    found = shape(signal_model, Crosstalk(), receiver, donor)
    assert_shows(signal_model, with_forces(signal_model, mixed), told(found, 0.05), without=PARITY)


@pytest.mark.parametrize("foot", [0, 1])
def test_cells_that_mix_still_lie_on_a_plane(signal_model: SignalModel, foot: int) -> None:
    """Which way it leans is found from the outputs, so that parity says nothing of crosstalk."""
    to, of = np.flatnonzero(signal_model.wiring.foot == foot)[:2]

    def mixed(_: object, force: FloatArray) -> FloatArray:
        shown = force.copy()
        shown[:, to] += 0.05 * force[:, of]
        return shown

    before, after = (
        one.with_planes(SignalSettings()).residuals[:, PARITY.start + foot]
        for one in (signal_model, with_forces(signal_model, mixed))
    )
    assert after.std() < 2.0 * before.std() + 1e-3


def test_swapped_cells_read_rightly_again(signal_model: SignalModel) -> None:
    one, other = 1, 6
    names = signal_model.samples.shoe.names
    order = np.arange(len(names))
    order[[one, other]] = other, one
    law = signal_model.parameters
    crossed = replace(
        signal_model,
        samples=replace(signal_model.samples, readings=signal_model.samples.readings[:, order]),
        parameters=replace(law, gain=law.gain[order], offset=law.offset[order]),
    )
    assert not np.allclose(crossed.wrench, signal_model.wrench)
    mended = shape(crossed, SwappedCells(), names[one], names[other]).signal_model
    assert mended is not None
    np.testing.assert_allclose(mended.wrench, signal_model.wrench)
    np.testing.assert_allclose(mended.foot_wrenches, signal_model.foot_wrenches)


def pushed(signal_model: SignalModel, push: FloatArray) -> SignalModel:
    """With efforts that hold the body while the floor also pushes feet by (2, 2) sideways [N]."""
    robot, states = signal_model.samples.robot, signal_model.samples.states
    model, data = robot.model, robot.model.createData()
    torque = np.zeros_like(signal_model.samples.angles)
    still = np.zeros(model.nv)
    for index in np.flatnonzero(signal_model.samples.frame == 0):
        base = pin.SE3(states.left_rotation[index], states.left_translation[index]).inverse()
        q = np.concatenate((pin.SE3ToXYZQUAT(base), signal_model.samples.angles[index]))
        outer = [pin.Force.Zero() for _ in range(model.njoints)]
        for number, foot in enumerate(robot.feet):
            force, about_x, about_y = signal_model.foot_wrenches[index, number]
            wrench = pin.Force(np.array([*push[number], force, about_x, about_y, 0.0]))
            outer[foot.joint] = foot.placement.act(wrench)
        torque[index] = pin.rnea(model, data, q, still, still, outer)[6:]
    tracks = []
    for track in signal_model.samples.tracks:
        owner = np.asarray(track.weights.argmax(axis=0)).ravel()
        tracks.append(replace(track, efforts=torque[track.samples][owner]))
    return replace(signal_model, samples=replace(signal_model.samples, tracks=tuple(tracks)))


def test_motors_hold_the_body_s_weight_against_the_floor(signal_model: SignalModel) -> None:
    still = pushed(signal_model, np.zeros((2, 2)))
    told_ = still.samples.decimated(lambda track: np.asarray(track.efforts))
    left, moved = signal_model.samples.frame == 0, signal_model.samples.robot.moved
    np.testing.assert_allclose(
        told_[left][:, moved], signal_model.links.torque[left][:, moved], atol=1e-6
    )


def test_off_axis_load_comes_with_the_sideways_forces_that_torques_tell(
    signal_model: SignalModel,
) -> None:
    push = np.array([[1.0, 2.0], [-0.5, -2.0]])
    after = pushed(signal_model, push)
    forces = sideways(after)
    assert forces is not None
    left = signal_model.samples.frame == 0
    np.testing.assert_allclose(forces[left], np.tile(push, (left.sum(), 1, 1)), atol=1e-3)
    change = np.zeros_like(signal_model.outputs)
    right = signal_model.wiring.foot == 1
    change[:, right] = (0.2 * forces[:, 1, 0] + 0.1 * forces[:, 1, 1])[:, None] / right.sum()
    found = shape(after, OffAxisLoad(), "right")
    np.testing.assert_allclose(told(found, 0.2, 0.1), after.by_outputs(change), atol=1e-9)


def test_without_efforts_no_off_axis_load_is_looked_for(signal_model: SignalModel) -> None:
    tracks = tuple(replace(track, efforts=None) for track in signal_model.samples.tracks)
    blind = replace(signal_model, samples=replace(signal_model.samples, tracks=tracks))
    assert not list(OffAxisLoad().shapes(blind, ("left",)))
