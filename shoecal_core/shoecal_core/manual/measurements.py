"""What was read under known loads, checked against the shoe."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FieldError, ShapeError, ShoecalError
from shoecal_core.manual.loads import CELLS, KINDS, Load
from shoecal_core.shoe.shoe import FEET, Shoe

LARGEST_MASS = 100.0
"""kg; anything heavier is a mass given in grams."""


class EntryError(ShoecalError):
    """One entry that cannot be used.

    Attributes:
        index: of the entry.
        key: field of it, as in the file.
        problem: what is wrong with it and what would be right.
    """

    def __init__(self, index: int, key: str, problem: str) -> None:
        self.index = index
        self.key = key
        self.problem = problem
        super().__init__(f"entries[{index}].{key}: {problem}")


@dataclass(frozen=True)
class LoadReading:
    """The mean reading under one load.

    Attributes:
        load: known.
        mean: (k,) of the foot's channels [unit]; NaN where one gave none.
        std: (k,) of one sample [unit]; NaN where not known.
        count: samples in the mean.
        made_ns: when [ns since the epoch], 0 where not known.
    """

    load: Load
    mean: FloatArray
    std: FloatArray
    count: int = 1
    made_ns: int = 0

    @property
    def noise(self) -> FloatArray:
        """(k,) standard deviation of the mean [unit]; NaN where not known."""
        noise: FloatArray = self.std / math.sqrt(self.count)
        return noise


@dataclass(frozen=True)
class Measurements:
    """Readings of one kind on one pair of shoes; holding them means that they fit the shoe.

    Attributes:
        kind: CELLS or SHOE.
        shoe: that was loaded.
        entries: one a load.
        path: the file they stand in; None where there is none.
    """

    kind: str
    shoe: Shoe
    entries: tuple[LoadReading, ...] = ()
    path: Path | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ShoecalError(f"kind '{self.kind}' is not one of: {', '.join(KINDS)}")
        seen: dict[Load, int] = {}
        for index, entry in enumerate(self.entries):
            _check_load(self.kind, self.shoe, index, entry.load)
            _check_readings(self.shoe, index, entry)
            first = seen.setdefault(entry.load, index)
            if first != index:
                raise EntryError(
                    index, "mass_kg", f"{entry.load}: is in entries[{first}] already; keep one"
                )

    def with_entry(self, entry: LoadReading) -> Measurements:
        """The same with one entry more, or in the place of the one of the same load."""
        kept = tuple(entry if other.load == entry.load else other for other in self.entries)
        entries = kept if entry.load in self.loads else (*kept, entry)
        return dataclasses.replace(self, entries=entries)

    @property
    def loads(self) -> frozenset[Load]:
        """The loads that were read."""
        return frozenset(entry.load for entry in self.entries)

    @property
    def end_ns(self) -> int:
        """When the last one was read [ns since the epoch]; 0 where not known."""
        return max((entry.made_ns for entry in self.entries), default=0)

    def of_foot(self, foot: int) -> tuple[LoadReading, ...]:
        """Entries of one foot."""
        return tuple(entry for entry in self.entries if entry.load.foot == foot)

    def of_cell(self, name: str) -> tuple[LoadReading, ...]:
        """Entries in which a cell bore the weight alone."""
        return tuple(entry for entry in self.entries if entry.load.place == name)

    def error(self, problem: str) -> ShoecalError:
        """The error to raise for what they lack."""
        return ShoecalError(problem) if self.path is None else FieldError(self.path, problem)


def stacked(entries: Sequence[LoadReading]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Masses (N,) [kg], means (N, k) and noise of the means (N, k) of entries of one foot."""
    return (
        np.array([entry.load.mass for entry in entries]),
        np.array([entry.mean for entry in entries]),
        np.array([entry.noise for entry in entries]),
    )


def _check_load(kind: str, shoe: Shoe, index: int, load: Load) -> None:
    if not 0.0 <= load.mass < math.inf:
        raise EntryError(index, "mass_kg", f"{load.mass:g} kg is no weight; give 0 or more")
    if load.mass > LARGEST_MASS:
        raise EntryError(
            index,
            "mass_kg",
            f"{load.mass:g} kg looks like grams; masses are in kg ({load.mass / 1e3:g})",
        )
    if kind == CELLS:
        if load.place not in shoe.names:
            raise EntryError(
                index, "cell", f"no cell '{load.place}' (there are: {', '.join(shoe.names)})"
            )
        return
    holes = shoe.holes[load.foot]
    if holes is None:
        raise EntryError(
            index, "foot", f"the {FEET[load.foot]} shoe has no holes in {shoe.path}; add them there"
        )
    if not load.place and load.mass:
        raise EntryError(index, "hole", f"is missing: say in which hole {load.mass:g} kg stood")
    if load.place and load.place not in holes.names:
        raise EntryError(
            index,
            "hole",
            f"the {FEET[load.foot]} shoe has no hole '{load.place}' "
            f"(there are: {holes.names[0]} to {holes.names[-1]})",
        )
    if load.place and not load.mass:
        raise EntryError(
            index, "mass_kg", "a hole without a weight; leave out the bare shoe's hole"
        )


def _check_readings(shoe: Shoe, index: int, entry: LoadReading) -> None:
    load = entry.load
    channels = shoe.of_foot(load.foot)
    for name, values in (("mean", entry.mean), ("std", entry.std)):
        if values.shape != channels.shape:
            raise ShapeError(f"entries[{index}].{name}", str(channels.shape), values.shape)
    if entry.count < 1 or (entry.std < 0.0).any():
        raise EntryError(index, "count", "a mean has at least one sample, and no negative std")
    for channel, value in zip(channels, entry.mean, strict=True):
        name = shoe.names[channel]
        if math.isnan(value) and (not load.alone or load.place == name):
            raise EntryError(index, "mean", f"{load}: the reading of {name} is missing")
        lowest, highest = shoe.channels[channel].lowest, shoe.channels[channel].highest
        if value < lowest or value > highest:
            raise EntryError(
                index,
                "mean",
                f"{name} reads {value:g} {shoe.unit}, outside its converter's {lowest:g} to "
                f"{highest:g} {shoe.unit}: is it in another unit?",
            )
        if value in (lowest, highest):
            raise EntryError(
                index,
                "mean",
                f"{name} is at the end of its range under {load}: take a lighter weight or lower "
                "its amplification",
            )
