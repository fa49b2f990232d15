"""What an effect adds to the signals, against how they really change."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.base import Effect, Shape
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import SIGNALS

ALIKE = (
    (0,), (1, 2), (3,), (4, 5), (6, 7, 8), (9, 10, 11), (12,), (13,), (14, 15),
)  # fmt: skip
"""Signals that are one vector, of one unit."""
LEAST = (6e-3, 1e-5, 6e-3, 2e-4, 5e-6, 3e-5, 1e-3, 1e-3, 3e-5)
"""Changes that are small against what no model tells count as none [N, m, N m, rad, 1]."""


def shape(signal_model: SignalModel, effect: Effect, *place: str, form: int = 0) -> Shape:
    """One form of an effect at a place."""
    assert place in set(effect.places(signal_model))
    return list(effect.shapes(signal_model, place))[form]


def told(found: Shape, *sizes: float) -> FloatArray:
    """(T, s) what sizes of its free components add."""
    return np.asarray(np.tensordot(np.array(sizes), found.columns, 1))


def assert_shows(
    before: SignalModel,
    after: SignalModel,
    foretold: FloatArray,
    within: float = 0.03,
    without: slice = slice(0),
) -> None:
    """The signals change as foretold (T, s), each within this share of its own change.

    Args:
        without: signals of which nothing is foretold.
    """
    change = after.residuals - before.residuals
    assert np.abs(change).max() > 0.0
    for signals, least in zip(ALIKE, LEAST, strict=True):
        names = [SIGNALS[index] for index in signals]
        if set(names) <= set(SIGNALS[without]):
            continue
        truth, guess = change[:, signals], foretold[:, signals]
        off, size = (float(np.sqrt(np.mean(one**2))) for one in (guess - truth, truth))
        assert off <= max(within * size, least), f"{names}: off by {off:.3g} of {size:.3g}"


def correlation(one: FloatArray, other: FloatArray, signals: Sequence[int]) -> float:
    """Cosine between two changes (T, s) in some signals."""
    a, b = one[:, signals].ravel(), other[:, signals].ravel()
    return float(a @ b / np.sqrt((a @ a) * (b @ b)))
