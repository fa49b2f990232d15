"""Known loads: weights, places, and the order in which a person puts them there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.errors import FieldError
from shoecal_core.shoe.shoe import FEET, Shoe

CELLS, SHOE = "cells", "shoe"
KINDS = (CELLS, SHOE)
"""What is loaded: single cells off their shoe, or the shoe's top plate."""


@dataclass(frozen=True)
class Load:
    """One weight at one place.

    Attributes:
        foot: index into FEET.
        place: name of the cell (`left/front_left`) that bears it alone, or of the hole with
            the weight; empty for the bare shoe.
        mass: of the weight [kg].
    """

    foot: int
    place: str
    mass: float

    @property
    def alone(self) -> bool:
        """Whether one cell off its shoe bears it."""
        return "/" in self.place

    def __str__(self) -> str:
        if self.alone:
            return f"{self.place} off its shoe, " + (
                f"{self.mass:g} kg" if self.mass else "no weight"
            )
        if not self.place:
            return f"{FEET[self.foot]} shoe, no weight"
        return f"{FEET[self.foot]} shoe, {self.mass:g} kg in hole {self.place}"


def planned_loads(
    kind: str, shoe: Shoe, weights: Sequence[float], feet: Sequence[int] | None = None
) -> tuple[Load, ...]:
    """Every load of a manual calibration, in an order with little carrying.

    A cell bears all weights before the next cell is taken; a weight walks through all holes,
    from each to the next one, before the next weight is taken.

    Args:
        kind: CELLS or SHOE.
        shoe: to be loaded.
        weights: one or more [kg].
        feet: of it; None: all that have channels.

    Raises:
        FieldError: when the shoe has no holes, or no cells that could bear a weight alone.
    """
    feet = shoe.feet if feet is None else feet
    if kind == CELLS:
        require_cells(shoe)
        return tuple(
            Load(foot, shoe.names[index], mass)
            for foot in feet
            for index in shoe.of_foot(foot)
            for mass in (0.0, *weights)
        )
    loads = []
    for foot in feet:
        holes = shoe.holes[foot]
        if holes is None:
            raise FieldError(
                shoe.path,
                "is missing: the shoe has no places for weights; add the rows and columns of its "
                "holes, x_m and y_m",
                field=f"feet.{FEET[foot]}.holes",
            )
        loads.append(Load(foot, "", 0.0))
        for index, mass in enumerate(weights):
            # The next weight starts where the one before ended.
            walk = holes.walk() if index % 2 == 0 else reversed(holes.walk())
            loads += [Load(foot, hole, mass) for hole in walk]
    return tuple(loads)


def require_cells(shoe: Shoe) -> None:
    """Refuse a shoe whose channels a weight cannot calibrate one by one.

    Raises:
        FieldError: for axes of a six-axis sensor.
    """
    others = [shoe.names[index] for index in np.flatnonzero(shoe.columns[:, 0] != 1.0)]
    others += [shoe.names[index] for index in np.flatnonzero(shoe.torque)]
    if others:
        raise FieldError(
            shoe.path,
            f"{', '.join(dict.fromkeys(others))}: no load cell that bears a weight alone; a manual "
            "calibration needs one-axis cells",
            field="feet",
        )
