"""A cell that gets stuck while others go on: told by the readings alone, before anything is fitted.

Weights and plates tie a shoe's cells to each other, so that each reading follows from the others by
one law. Where a cell stops, its law changes at a moment, and its reading hardly follows any more.
What it should have shown follows from the law before: with that in its place, gains are fitted and
all else is looked for as if it had never stopped.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.result import Cause, Size
from shoecal_core.diagnosis.shrink import shrink
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.effects import places
from shoecal_core.samples.samples import Samples

FloatArray = NDArray[np.float64]
BROKEN = 0.05
"""Squares that two laws leave, over those of one, up to which a law has changed."""
FOLLOWS = 0.35
"""Share of its course up to which a reading hardly follows any more."""
ONE_IN = 20
"""This part of all samples is on either side, so that either law can be told."""
SHARE_ERROR = 0.05
"""How far the share that stays may be off, as an interval's half width."""


@dataclass(frozen=True)
class Stopped:
    """A cell that got stuck.

    Attributes:
        channel: which.
        time: since the session began [s]; step: to the sample before it.
        share: of its signal that stays.
        law: (1 + n,) by which it followed all channels before, a constant first.
    """

    channel: int
    time: float
    step: float
    share: float
    law: FloatArray

    def cause(self, before: Workspace, mended: Workspace) -> Cause:
        """What it is, by what is left with the readings as they came and as mended."""
        place = (mended.scene.samples.shoe.names[self.channel],)
        return Cause(
            effect="stuck_cell",
            group="load_cell",
            location=place,
            probability=1.0,
            size={
                "share": Size(self.share, "", _around(self.share, SHARE_ERROR)),
                "time": Size(self.time, "s", _around(self.time, self.step)),
            },
            run=None,
            shrink=shrink(mended, before.explained(None)[0], mended.explained(None)[0]),
            hidden_cop_mm=0.0,
        )

    def mended(self, samples: Samples) -> Samples:
        """The session as the cell would have shown it."""
        tracks = tuple(
            replace(one, readings=self._mended(one.readings, one.start + one.time))
            for one in samples.tracks
        )
        readings = self._mended(samples.readings, samples.clock)
        return replace(samples, tracks=tracks, readings=readings)

    def _mended(self, readings: FloatArray, clock: FloatArray) -> FloatArray:
        mended = readings.copy()
        late = clock >= self.time
        mended[late, self.channel] = self.law[0] + readings[late] @ self.law[1:]
        return mended


def stopped(samples: Samples) -> Stopped | None:
    """The cell whose law changes most clearly, if one stops."""
    order = np.argsort(samples.clock)
    readings, clock = samples.readings[order], samples.clock[order]
    cells = places.cells(samples.shoe)
    found = [(change, cell) for cell in cells if (change := _change(readings, int(cell), cells))]
    if not found:
        return None
    (_, at, share, law), channel = min(found, key=lambda one: one[0][0])
    step = float(clock[at] - clock[at - 1])
    return Stopped(int(channel), float(clock[at] - 0.5 * step), step, share, law)


def _change(
    readings: FloatArray, channel: int, cells: NDArray[np.int64]
) -> tuple[float, int, float, FloatArray] | None:
    """How clearly a law changes (0: wholly), from which sample on, the share, and the law."""
    others = cells[cells != channel]
    spread = readings[:, others].std(axis=0)
    least = len(readings) // ONE_IN
    if not spread.all() or least < 2 * len(cells):
        return None
    matrix = np.column_stack((np.ones(len(readings)), readings[:, others] / spread))
    mean = readings[:, channel].mean()
    values = readings[:, channel] - mean
    normal = np.cumsum(matrix[:, :, None] * matrix[:, None, :], axis=0)
    right = np.cumsum(matrix * values[:, None], axis=0)
    explained = _explained(normal, right) + _explained(normal[-1] - normal, right[-1] - right)
    left = values @ values - explained[least:-least]
    at = least + int(np.argmin(left)) + 1
    clear = float(
        left.min() / max(values @ values - _explained(normal[-1:], right[-1:])[0], 1e-300)
    )
    if clear > BROKEN:
        return None
    solved = np.linalg.lstsq(matrix[:at], values[:at], rcond=None)[0]
    told = matrix @ solved
    follows = float(np.polyfit(told[at:], values[at:], 1)[0])
    if abs(follows) > FOLLOWS:
        return None
    law = np.zeros(1 + readings.shape[1])
    law[0], law[1 + others] = solved[0] + mean, solved[1:] / spread
    return clear, at, 1.0 - follows, law


def _around(value: float, either: float) -> tuple[float, float]:
    return value - either, value + either


def _explained(normal: FloatArray, right: FloatArray) -> FloatArray:
    """(n,) squares that least squares take away, by n normal equations."""
    steady = 1e-9 * np.trace(normal[-1] + normal[0]) * np.eye(normal.shape[1])
    solution = np.linalg.solve(normal + steady, right[:, :, None])[:, :, 0]
    found: FloatArray = np.sum(right * solution, axis=1)
    return found
