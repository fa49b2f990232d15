"""How large a drawn law must be to make a gap: found on the set that it is for."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from blind.answers import Answer, Foreign, Truth
from blind.draws import own_gap, unit_floor
from blind.felt import Felt
from blind.gap import gap_of_change
from blind.laws import Law, drawn_law
from blind.unknown_laws import FUNCTIONS, unknown_law
from blind.world import over_perfect
from shoecal_core.arrays import FloatArray

_TRIES, _NEAR = 12, 0.05
"""Sizes tried, and how near to the aim, as a logarithm, is near enough."""
_FIRST = 0.1
"""Of the largest size: where to begin."""


class Sized(NamedTuple):
    """A law at the size that was asked for."""

    size: float
    forces: FloatArray


def sized(law: Law, felt: Felt, gap: float) -> Sized:
    """A law at the size at which it makes a gap over a perfect robot's floor, or at its largest.

    The change of forces makes errors in proportion, so that one step is enough for a law that is
    linear in its size; others are bracketed.
    """
    aim, tried = np.log(own_gap(gap)), dict[float, float]()
    size = _FIRST * law.most
    for _ in range(_TRIES):
        own = gap_of_change(felt, law.shown(size) - felt.forces).largest(unit_floor())
        tried[size] = float(np.log(max(own, 1e-6)) - aim)
        size = min(law.most, _next(tried))
        if abs(tried[best := min(tried, key=lambda one: abs(tried[one]))]) < _NEAR or size in tried:
            break
    return Sized(best, law.shown(best))


def _next(tried: dict[float, float]) -> float:
    """Where to look after sizes with their logarithms over the aim: between, else in proportion."""
    below = max((one for one, away in tried.items() if away < 0.0), default=None)
    above = min((one for one, away in tried.items() if away >= 0.0), default=None)
    if below is not None and above is not None:
        return float(np.sqrt(below * above))
    (size, away) = list(tried.items())[-1]
    return size * float(np.exp(-np.clip(away, -3.0, 3.0)))


def as_shown(answer: Answer, true: Felt) -> tuple[Felt, list[float]]:
    """Forces as all drawn laws show them, one after the other, and the sizes of these."""
    shown, sizes = true, []
    for one in (*answer.truths, answer.foreign):
        if isinstance(one, Truth) and one.seed is not None:
            law = drawn_law(shown, one.effect, one.location, one.seed, one.onset)
        elif isinstance(one, Foreign) and one.kind in FUNCTIONS:
            law = unknown_law(shown, one.kind, one.seed)
        else:
            continue
        size, forces = sized(law, shown, over_perfect(answer, one.strength))
        shown = dataclasses.replace(shown, forces=forces)
        sizes.append(size)
    return shown, sizes
