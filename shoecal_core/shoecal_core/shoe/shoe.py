"""What is known of a pair of force-sensing shoes: its channels, plates and weights.

A channel is anything that adds to the vertical force F and the floor moments Mx, My of a
foot: a one-axis load cell or one axis of a six-axis sensor. Its column of (F, Mx, My) is
fixed and given in the foot's sole frame: origin on the floor below the foot, x forward,
y left, z up.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.errors import NameNotFoundError
from shoecal_core.shoe.holes import Holes

FEET = ("left", "right")
AXES = ("fx", "fy", "fz", "mx", "my")
"""Axes of a six-axis sensor that act on F, Mx, My (mz acts on none of them)."""


@dataclass(frozen=True)
class Channel:
    """One source of force.

    Attributes:
        name: `foot/cell`, for example `left/front_left`.
        foot: index into FEET.
        column: (3,) F [1], Mx [m], My [m] for one newton of output (for a torque channel:
            [1/m], [1], [1] for one newton metre).
        position: (2,) place in the sole frame [m]; a sensor's axes share their sensor's.
        torque: the output is a torque [N m], else a force [N].
        polarity: +1 or -1 where the sign of the reading under load is known, else 0.
        nominal_gain: output per reading by the maker's data sheet, None where it is not known.
        lowest, highest: readings at the ends of the converter's range.
    """

    name: str
    foot: int
    column: FloatArray
    position: FloatArray
    torque: bool
    polarity: int
    nominal_gain: float | None
    lowest: float
    highest: float

    @property
    def rough_gain(self) -> float:
        """Output per reading: its size by the data sheet, its sign by the polarity; each as if it
        were 1 where it is not known.
        """
        return abs(self.nominal_gain or 1.0) * (self.polarity or 1)

    @property
    def vertical(self) -> bool:
        """Whether it feels vertical force itself: a cell, or that axis of a six-axis sensor.

        Others have a small part in the force where crosstalk has been fitted.
        """
        return not self.torque and float(self.column[0]) > 0.5


@dataclass(frozen=True)
class Plates:
    """Masses of one shoe, in the sole frame.

    Attributes:
        mass_above: carried by the channels, moves with the robot's foot [kg].
        com_above: (3,) its centre of mass [m].
        mass_below: between the channels and the floor [kg].
        com_below: (3,) its centre of mass [m].
    """

    mass_above: float
    com_above: FloatArray
    mass_below: float
    com_below: FloatArray


NO_PLATES = Plates(0.0, np.zeros(3), 0.0, np.zeros(3))
"""Of the foot that a single shoe's file does not have."""


@dataclass(frozen=True)
class Shoe:
    """A pair of shoes (or feet) with their channels.

    Attributes:
        name: of this kind of shoe.
        unit: of the readings, for example V.
        height: from the shoe's floor side up to the robot's own sole [m].
        channels: in the order used by every array of channels.
        plates: left, right.
        path, digest: the file it came from and its SHA-256.
        holes: left, right: where known weights can stand; None for a shoe without such places.
    """

    name: str
    unit: str
    height: float
    channels: tuple[Channel, ...]
    plates: tuple[Plates, Plates]
    path: Path
    digest: str
    holes: tuple[Holes | None, Holes | None] = (None, None)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Channel names, n of them."""
        return tuple(channel.name for channel in self.channels)

    @cached_property
    def foot(self) -> IntArray:
        """(n,) index into FEET."""
        return np.array([channel.foot for channel in self.channels])

    @cached_property
    def columns(self) -> FloatArray:
        """(n, 3) F, Mx, My per unit of output, each in its own foot's sole frame."""
        return np.array([channel.column for channel in self.channels])

    @cached_property
    def positions(self) -> FloatArray:
        """(n, 2) places in each foot's sole frame [m]."""
        return np.array([channel.position for channel in self.channels])

    @cached_property
    def vertical(self) -> BoolArray:
        """(n,) True for channels of vertical force."""
        return np.array([channel.vertical for channel in self.channels])

    @cached_property
    def torque(self) -> BoolArray:
        """(n,) True where the output is a torque [N m]."""
        return np.array([channel.torque for channel in self.channels])

    @cached_property
    def polarity(self) -> IntArray:
        """(n,) +1, -1, or 0 where unknown."""
        return np.array([channel.polarity for channel in self.channels])

    @cached_property
    def feet(self) -> tuple[int, ...]:
        """Indices into FEET of the feet that have channels: both, or that of a single shoe."""
        return tuple(sorted(set(self.foot.tolist())))

    @cached_property
    def gives_cop(self) -> tuple[bool, bool]:
        """Left, right: the channels give both moments; without them there is a force alone."""
        ranks = [np.linalg.matrix_rank(self.columns[self.of_foot(i)], tol=1e-6) for i in (0, 1)]
        return bool(ranks[0] == 3), bool(ranks[1] == 3)

    def of_one_foot(self, foot: int) -> Shoe:
        """The same with the channels of one foot only."""
        own = tuple(channel for channel in self.channels if channel.foot == foot)
        return replace(self, channels=own)

    @property
    def mass(self) -> float:
        """Mass of both shoes [kg]."""
        return sum(plates.mass_above + plates.mass_below for plates in self.plates)

    def with_columns(self, columns: FloatArray) -> Shoe:
        """The same with other columns (n, 3)."""
        channels = tuple(
            replace(channel, column=column)
            for channel, column in zip(self.channels, columns, strict=True)
        )
        return replace(self, channels=channels)

    def index(self, name: str) -> int:
        """Place of a channel in the arrays."""
        try:
            return self.names.index(name)
        except ValueError:
            raise NameNotFoundError("channel", name, self.names) from None

    def of_foot(self, foot: int) -> IntArray:
        """(k,) indices of one foot's channels."""
        return np.flatnonzero(self.foot == foot)


def cell_column(position: FloatArray) -> FloatArray:
    """Column (1, t_y, -t_x) of a vertical load cell at `position` (2,) [m]."""
    return np.array([1.0, position[1], -position[0]])


def axis_column(axis: str, origin: FloatArray) -> FloatArray:
    """Column of one axis of a six-axis sensor at `origin` (3,) [m] above the floor.

    Moments about the sole frame's origin: M = r x f for forces, M itself for torques.
    """
    x, y, h = origin
    columns = {
        "fx": (0.0, 0.0, h),
        "fy": (0.0, -h, 0.0),
        "fz": (1.0, y, -x),
        "mx": (0.0, 1.0, 0.0),
        "my": (0.0, 0.0, 1.0),
    }
    return np.array(columns[axis])
