"""Effects of where and what cells feel: places, exchanges, mixtures."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations, permutations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.base import Component, Place, Shape
from shoecal_core.error_sources.effects import places
from shoecal_core.error_sources.effects.load_cell import shown
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import AIR, PARITY
from shoecal_core.error_sources.wiring import Wiring
from shoecal_core.shoe.shoe import FEET


class CellPosition:
    """A cell, or a six-axis sensor, acts elsewhere than the shoe file says."""

    identifier, group = "cell_position", "load_cell"
    components = tuple(
        Component(name, "m", 0.004, most=0.025, as_built="cell_position_m") for name in "xy"
    )

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every cell; of a six-axis sensor the channel of its vertical force."""
        return places.each_cell(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """The moment that the file's place misses; it is turned with its foot."""
        (channel,) = places.channels_at(signal_model, place)
        force = signal_model.outputs[:, channel]
        foot = int(signal_model.wiring.foot[channel])
        samples = signal_model.samples
        stands = samples.loaded[:, foot]
        alone = ~samples.both
        yaw = np.array([support.dtheta for support in signal_model.supports])[samples.segment]
        turn = np.where(alone | (foot == 0), 0.0, yaw)
        c, s = np.cos(turn), np.sin(turn)
        columns = []
        for x, y in ((1.0, 0.0), (0.0, 1.0)):
            # Truly at t + d: the force's moment by the file's t is short of d x f.
            dx, dy = c * x - s * y, s * x + c * y
            wrench = np.stack((np.zeros_like(force), -dy * force, dx * force), axis=1)
            column = signal_model.by_wrench(np.where(stands[:, None], wrench, 0.0))
            hanging = np.stack((0.0 * force, -y * force, x * force), axis=1)
            column[:, AIR] = np.where(~stands[:, None] & signal_model.mask[:, AIR], hanging, 0.0)
            columns.append(column)
        yield Shape(("x", "y"), np.array(columns))


class Crosstalk:
    """A channel shows a part of what another one feels.

    Between a force and a torque of a six-axis sensor the fraction is a lever [m], or its inverse.
    """

    identifier, group = "crosstalk", "load_cell"
    components = (Component("fraction", "", 0.08, most=0.3, as_built="crosstalk"),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Receiver and donor of one foot's cells, which share a board; axes of one sensor."""
        shoe = signal_model.samples.shoe
        for receiver, donor in permutations(places.cells(shoe), 2):
            if shoe.foot[receiver] == shoe.foot[donor]:
                yield (shoe.names[receiver], shoe.names[donor])
        for receiver, donor in places.coupled_axes(shoe):
            yield (shoe.names[receiver], shoe.names[donor])

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """The donor's force."""
        receiver, donor = (signal_model.samples.shoe.names.index(name) for name in place)
        column = shown(signal_model, np.array([receiver]), signal_model.outputs[:, [donor]])
        # Which way a plane leans is found from the outputs; mixed ones lie on one as well.
        column[:, PARITY] = 0.0
        yield Shape(("fraction",), column[None])


class SwappedCells:
    """Two cells come as each other."""

    identifier, group = "swapped_cells", "load_cell"
    components: tuple[Component, ...] = ()

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Every two cells."""
        shoe = signal_model.samples.shoe
        for one, other in combinations(places.cells(shoe), 2):
            yield (shoe.names[one], shoe.names[other])

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Each channel at the other's place."""
        one, other = (signal_model.samples.shoe.names.index(name) for name in place)
        order = np.arange(len(signal_model.wiring.foot))
        order[[one, other]] = other, one
        wiring = Wiring(signal_model.wiring.columns[order], signal_model.wiring.foot[order])
        exchanged = replace(
            signal_model,
            wiring=wiring,
            planes=np.zeros_like(signal_model.planes)
            if signal_model.wiring.foot[one] != signal_model.wiring.foot[other]
            else signal_model.planes,
        )
        yield Shape((), np.zeros((0, *signal_model.residuals.shape)), signal_model=exchanged)


class OffAxisLoad:
    """Cells show a part of the sideways force on their foot."""

    identifier, group = "off_axis_load", "load_cell"
    components = (Component("x", "", 0.1), Component("y", "", 0.1))

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Each foot that has cells."""
        shoe = signal_model.samples.shoe
        for foot in sorted({int(shoe.foot[index]) for index in places.cells(shoe)}):
            yield (FEET[foot],)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """Sideways forces by the torques of the leg's joints."""
        forces = sideways(signal_model)
        if forces is None:
            return
        foot = FEET.index(place[0])
        channels = places.channels_at(signal_model, place)
        share = np.full((1, len(channels)), 1.0 / len(channels))
        columns = [
            shown(signal_model, channels, forces[:, foot, axis][:, None] * share) for axis in (0, 1)
        ]
        yield Shape(("x", "y"), np.array(columns))


def sideways(signal_model: SignalModel) -> FloatArray | None:
    """(T, 2, 2) force of the floor on each foot along x and y of its sole [N].

    What the motors' torques miss against those that the vertical forces alone ask for, by
    least squares over each leg's joints. None where no efforts were recorded.
    """
    samples = signal_model.samples
    if samples.efforts is None:
        return None
    missing = samples.efforts - signal_model.links.torque
    joints = samples.robot.moved
    side = signal_model.links.side[:, :, :2][..., joints]
    forces = np.zeros((len(missing), 2, 2))
    for index in range(len(missing)):
        # torque = ... - J' f: a force on the foot lightens the motors.
        matrix = -side[index].reshape(4, -1).T
        forces[index] = np.linalg.lstsq(matrix, missing[index, joints], rcond=1e-3)[0].reshape(2, 2)
    return forces
