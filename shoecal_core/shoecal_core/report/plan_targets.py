"""The places that a planned CoP pursued, and how near it came."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

SAME = 1e-3
"""m; places nearer to each other than this are drawn as one."""


@dataclass(frozen=True)
class Target:
    """A place that the CoP pursued.

    Attributes:
        number: in the order of pursuit, from 1.
        place: (2,) in the world [m].
        nearest: the planner's distance to it, of the torso's lean and height too where these were
            pursued; infinite where it was never pursued [m].
        cop_distance: of the CoP alone [m].
        reached: it came as near as it should.
        sample: of the motion at which the CoP was nearest; -1 where never pursued.
    """

    number: int
    place: FloatArray
    nearest: float
    cop_distance: float
    reached: bool
    sample: int

    @property
    def pursued(self) -> bool:
        """Whether the planner came to it at all."""
        return bool(np.isfinite(self.nearest))

    def off(self, radius: float) -> str:
        """What is missing: the distance, or what else.

        Args:
            radius: within which a landmark is reached [m].
        """
        if not self.pursued:
            return "never pursued"
        if self.cop_distance < radius:
            return "lean or height off"
        return f"{1e3 * self.nearest:.1f} mm off"


@dataclass(frozen=True)
class TargetMark:
    """Targets at one place, as figures show them.

    Attributes:
        numbers: for example `1, 3–5`.
        missing: of the worst that was not reached; empty where all were.
        place: (2,) [m].
    """

    numbers: str
    missing: str
    place: FloatArray

    @property
    def label(self) -> str:
        """Its numbers and what is missing."""
        return f"{self.numbers}: {self.missing}" if self.missing else self.numbers


def marks_of(targets: Sequence[Target], radius: float) -> tuple[TargetMark, ...]:
    """Each place once, in the order of first pursuit.

    Args:
        targets: of a motion.
        radius: within which a landmark is reached [m].
    """
    groups: list[list[Target]] = []
    for target in targets:
        for group in groups:
            if np.linalg.norm(group[0].place - target.place) < SAME:
                group.append(target)
                break
        else:
            groups.append([target])
    marks = []
    for group in groups:
        missed = [one for one in group if not one.reached]
        worst = max(missed, key=lambda one: one.nearest, default=None)
        marks.append(
            TargetMark(
                numbers=", ".join(_runs([one.number for one in group])),
                missing="" if worst is None else worst.off(radius),
                place=group[0].place,
            )
        )
    return tuple(marks)


def _runs(numbers: Sequence[int]) -> Iterator[str]:
    """Neighbouring numbers as `3–5`."""
    begin = 0
    for index in range(1, len(numbers) + 1):
        if index == len(numbers) or numbers[index] != numbers[index - 1] + 1:
            first, last = numbers[begin], numbers[index - 1]
            yield str(first) if first == last else f"{first}–{last}"
            begin = index
