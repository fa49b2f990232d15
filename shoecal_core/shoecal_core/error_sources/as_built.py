"""All errors that a robot has that works as it was built: nuisances of every fit.

Each is linear near zero. Its column says what one unit of it adds to measured minus modelled, in
every signal; those of the shoe also say how the channels' columns truly are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.error_sources.base import ALL, Effect, deviations
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.error_sources.effects import body, contact, geometry, places, timing
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import AIR
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.shoe.priors import TORQUE_LEVER_M
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import to_left

AXES = ("x", "y")
PLATES_FORM = 0.2
"""Part of what plates carry that is in no proportion to the moment."""
SENSOR_LEVER_M = 0.05
"""Range of torques over that of forces in six-axis sensors: crosstalk is given of full scales."""
FEWEST_CELLS = 3
"""Of a foot whose plates may carry a part of the moment past its cells."""


def as_built(signal_model: SignalModel, tolerances: Tolerances) -> list[Deviation]:
    """Every deviation with a standard deviation above zero, linear about a signal model; gears
    in all forms that a diagnosis knows.
    """
    found = [
        *of_body(signal_model, tolerances, in_all_forms=True),
        *of_shoes(signal_model, tolerances),
    ]
    found += deviations(timing.Latency(), signal_model, tolerances, [(ALL,)])
    return [*found, *of_setup(signal_model, tolerances)]


def of_body(
    signal_model: SignalModel, tolerances: Tolerances, *, in_all_forms: bool = False
) -> list[Deviation]:
    """Of links, joints and soles: what gains and offsets hardly change."""
    joints = _joints(signal_model, tolerances, in_all_forms=in_all_forms)
    found = [*_links(signal_model, tolerances), *joints, *_soles(signal_model, tolerances)]
    return [one for one in found if one.std > 0.0]


def of_shoes(signal_model: SignalModel, tolerances: Tolerances) -> list[Deviation]:
    """Of channels, plates and single runs: what follows the outputs."""
    found = [*_channels(signal_model, tolerances), *_runs(signal_model, tolerances)]
    return [one for one in found if one.std > 0.0]


def of_setup(signal_model: SignalModel, tolerances: Tolerances) -> list[Deviation]:
    """Of the floor, and of shoes as they were put on: what cells and stances hardly show."""
    crosstalk = geometry.Crosstalk()
    axes = set(_coupled_axes(signal_model.samples.shoe))
    cells = [place for place in crosstalk.places(signal_model) if place not in axes]
    found = [*deviations(crosstalk, signal_model, tolerances, cells)]
    for source in (contact.FloorTilt(), contact.FootPlacement()):
        found += deviations(source, signal_model, tolerances, source.places(signal_model))
    return [one for one in found if one.std > 0.0]


def _links(signal_model: SignalModel, tolerances: Tolerances) -> Iterator[Deviation]:
    com = body.LinkCom()
    yield from deviations(com, signal_model, tolerances, com.places(signal_model))
    links, samples = signal_model.links, signal_model.samples
    own = samples.states.com[np.arange(len(samples.run)), samples.frame, :2]
    for (name,) in com.places(signal_model):
        index = links.names.index(name)
        # The total is weighed: what one link weighs more all others weigh less.
        share = links.mass[index] / samples.robot.mass
        column = (
            signal_model.by_model(0.0, share * (links.com[:, index, :2] - own)) * signal_model.mask
        )
        yield Deviation("link_mass", (name,), "share", "", tolerances.link_mass, column)


def _joints(
    signal_model: SignalModel, tolerances: Tolerances, *, in_all_forms: bool
) -> Iterator[Deviation]:
    zero = body.JointOffset()
    yield from deviations(zero, signal_model, tolerances, zero.places(signal_model))
    # Play that is pushed; dragged it is friction.
    gives, pushed = (body.GIVES, len(body.FRICTION)) if in_all_forms else (1, 1)
    gears: list[tuple[Effect, int]] = [
        (body.JointCompliance(), gives),
        (body.Backlash(), pushed),
    ]
    if in_all_forms:
        gears.append((body.JointFriction(), 1))
    # Gears of one robot are alike, and differ a little: one number in common, one a joint.
    for gear, forms in gears:
        yield from deviations(gear, signal_model, tolerances, [(ALL,)], forms=forms)
        each = places.each_joint(signal_model)
        for one in deviations(gear, signal_model, tolerances, each, forms=forms):
            yield replace(one, std=tolerances.gear_spread * one.std)


def _soles(signal_model: SignalModel, tolerances: Tolerances) -> Iterator[Deviation]:
    yield from deviations(
        contact.SoftGround(), signal_model, tolerances, places.each_foot(signal_model)
    )


def _channels(signal_model: SignalModel, tolerances: Tolerances) -> Iterator[Deviation]:
    shoe = signal_model.samples.shoe
    cell = geometry.CellPosition()
    for one in deviations(cell, signal_model, tolerances, cell.places(signal_model)):
        change = np.zeros((len(shoe.names), 3))
        index = shoe.index(one.location[0])
        change[index] = shoe.columns[index, 0] * _moved(one.component, 1.0)
        yield replace(one, shoe_column=change)
    for side in FEET:
        for axis in AXES if len(_cells(shoe, side)) >= FEWEST_CELLS else ():
            change = plates_column(shoe, side, axis)
            column = -by_columns(signal_model, change)
            std = tolerances.plate_share
            yield Deviation(
                "plates", (side,), axis, "", std, column, form=PLATES_FORM, shoe_column=change
            )

    for one in deviations(geometry.Crosstalk(), signal_model, tolerances, _coupled_axes(shoe)):
        receiver, donor = (shoe.index(name) for name in one.location)
        ranges = SENSOR_LEVER_M ** (int(shoe.torque[receiver]) - int(shoe.torque[donor]))
        change = np.zeros((len(shoe.names), 3))
        change[donor] = -shoe.columns[receiver]
        yield replace(one, std=ranges * one.std, shoe_column=change)


def _coupled_axes(shoe: Shoe) -> list[tuple[str, ...]]:
    return [
        (shoe.names[receiver], shoe.names[donor]) for receiver, donor in places.coupled_axes(shoe)
    ]


def _runs(signal_model: SignalModel, tolerances: Tolerances) -> Iterator[Deviation]:
    """What may differ from run to run: zeros, and where the right foot stands."""
    samples = signal_model.samples
    for run in samples.runs:
        here = samples.run == run
        for channel, name in enumerate(samples.shoe.names):
            change = np.zeros_like(signal_model.outputs)
            change[here, channel] = 1.0
            torque = bool(samples.shoe.torque[channel])
            std = tolerances.run_zero_n * (TORQUE_LEVER_M if torque else 1.0)
            unit = "N m" if torque else "N"
            column = signal_model.by_outputs(change)
            yield Deviation("zero_offset", (name,), "offset", unit, std, column, run=run, form=0.0)
    stds = (tolerances.support_m, tolerances.support_m, tolerances.support_rad)
    for segment, (left, right) in enumerate(samples.standing):
        if not (left and right):
            continue
        here = samples.segment == segment
        run = int(samples.run[here][0])
        for axis, (name, std) in enumerate(zip(("dx", "dy", "dtheta"), stds, strict=True)):
            change = np.zeros((len(here), 3))
            change[here, axis] = 1.0
            # The foot truly stands further: the measured CoP takes it for where it was.
            column = signal_model.by_support(-change)
            unit = "rad" if name == "dtheta" else "m"
            place = (f"segment {segment}",)
            yield Deviation("support", place, name, unit, std, column, run=run)


def by_columns(signal_model: SignalModel, change: FloatArray) -> FloatArray:
    """(T, s) when the channels' columns are taken to be `change` (n, 3) more, each foot's own."""
    wiring = signal_model.wiring
    right = (wiring.foot == 1)[:, None]
    stacked = []
    for (stands_left, stands_right), support in zip(
        signal_model.samples.standing, signal_model.supports, strict=True
    ):
        if stands_left and stands_right:
            stacked.append(np.where(right, change @ to_left(support).T, change))
        else:
            foot = 0 if stands_left else 1
            stacked.append(np.where((wiring.foot == foot)[:, None], change, 0.0))
    per_sample = np.array(stacked)[signal_model.samples.segment]
    wrench = np.einsum("tn,tnw->tw", signal_model.outputs, per_sample)
    found = signal_model.by_wrench(wrench, settled=False)
    feet = [
        signal_model.outputs @ np.where((wiring.foot == foot)[:, None], change, 0.0)
        for foot in (0, 1)
    ]
    found[:, AIR] = signal_model.hanging(np.stack(feet, axis=1))
    return signal_model.settled(found)


def plates_column(shoe: Shoe, side: str, axis: str) -> FloatArray:
    """(n, 3) when the cells of a foot act further from their middle by their whole distance.

    A share s of the moment that plates carry past the cells is s / (1 - s) of it.
    """
    own = _cells(shoe, side)
    change = np.zeros((len(shoe.names), 3))
    place = shoe.positions[own, AXES.index(axis)]
    for cell, lever in zip(own, place - place.mean(), strict=True):
        change[cell] = shoe.columns[cell, 0] * _moved(axis, float(lever))
    return change


def _cells(shoe: Shoe, side: str) -> IntArray:
    """Channels of a foot that feel its vertical force."""
    own = shoe.of_foot(FEET.index(side))
    felt: IntArray = own[shoe.vertical[own]]
    return felt


def _moved(axis: str, length: float) -> FloatArray:
    """(3,) column of a force that acts further along x or y by a length [m]."""
    return np.array([0.0, 0.0, -length] if axis == "x" else [0.0, length, 0.0])
