"""Pairs that nothing in a recording can separate: there the right answer is the set."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from blind.answers import Place, Truth
from population import nao

Alike = Callable[[Truth, np.random.Generator], tuple[Truth, tuple[Place, ...]]]


@dataclass(frozen=True)
class Pair:
    """An effect that looks like another one in a recording that lacks something.

    Attributes:
        effect: that is put in.
        kind: of place.
        lacking: motions that are not recorded.
        imu: whether an inertial sensor is.
        alike: the effect as it is put in, and the right answer.
    """

    effect: str
    kind: str
    lacking: frozenset[str]
    imu: bool
    alike: Alike


_UNLOADING = frozenset(("unload_left", "unload_right"))
_HEIGHTS = _UNLOADING | {"torso_height"}


def _heard(truth: Truth, _: np.random.Generator) -> tuple[Truth, tuple[Place, ...]]:
    """Crosstalk: the donor's place is off along the line to the receiver."""
    return truth, (truth.place, Place("cell_position", truth.location[1:]))


def _displaced(truth: Truth, rng: np.random.Generator) -> tuple[Truth, tuple[Place, ...]]:
    """A cell off its place, towards another one of its foot: that one may hear it as well."""
    shoe = nao()[1]
    (cell,) = truth.location
    foot = cell.split("/")[0]
    other = str(rng.choice([name for name in shoe.names if name.startswith(foot) and name != cell]))
    way = shoe.positions[shoe.names.index(other)] - shoe.positions[shoe.names.index(cell)]
    size = float(np.hypot(truth.size["x"], truth.size["y"])) * float(rng.choice([-1.0, 1.0]))
    x, y = (size * way / np.linalg.norm(way)).tolist()
    moved = dataclasses.replace(truth, size={"x": x, "y": y})
    return moved, (truth.place, Place("crosstalk", (other, cell)))


def _either_foot(truth: Truth, _: np.random.Generator) -> tuple[Truth, tuple[Place, ...]]:
    """Feet tell that they moved against each other, not which of them."""
    return truth, (Place("slip", ("left",)), Place("slip", ("right",)))


def _slope(truth: Truth, _: np.random.Generator) -> tuple[Truth, tuple[Place, ...]]:
    """At one height of the torso a slope shifts the CoP as a CoM off its place does."""
    return truth, (truth.place, Place("link_com", ("base",)))


def _late(truth: Truth, _: np.random.Generator) -> tuple[Truth, tuple[Place, ...]]:
    """In slow motion a filter is a delay."""
    other = "low_pass" if truth.effect == "latency" else "latency"
    return truth, (truth.place, Place(other, truth.location))


PAIRS: tuple[Pair, ...] = (
    Pair("crosstalk", "pair", _UNLOADING, True, _heard),
    Pair("slip", "foot", frozenset(), True, _either_foot),
    Pair("latency", "all", _UNLOADING | {"faster"}, True, _late),
    Pair("cell_position", "cell", _UNLOADING, True, _displaced),
    Pair("floor_tilt", "none", _HEIGHTS, False, _slope),
    Pair("low_pass", "foot", _UNLOADING | {"faster"}, True, _late),
)
"""Taken in turn."""
