"""One reading: samples in a row that stand still."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import Enum

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.manual.loads import Load
from shoecal_core.manual.settings import ManualSettings
from shoecal_core.shoe.shoe import Shoe

CHANGED = 3.0
"""A new load changes a channel by more than this, in the largest std of a still reading."""


class StillState(Enum):
    """How far a reading is."""

    UNDER_WAY = "under way"
    STILL = "still"
    MOVED = "moved while reading: again"
    UNCHANGED = (
        "nothing has changed since the last reading: put the weight in its place, then again"
    )
    SILENT = "not all cells gave readings: check their wiring, then again"


@dataclass(frozen=True)
class Last:
    """The reading before: of which load, and its mean (k,) [unit]."""

    load: Load
    mean: FloatArray


class StillReading:
    """Takes samples of one foot until the last of them stand still.

    Attributes:
        load: that is read.
        taken: samples since it began.
    """

    def __init__(self, shoe: Shoe, load: Load, settings: ManualSettings, last: Last | None) -> None:
        """None taken.

        Args:
            shoe: whose channels are read.
            load: on it.
            settings: how many samples, how still, and for how long to try.
            last: the reading before, if there was one: another load must differ from it.
        """
        self.load = load
        self.taken = 0
        self._settings = settings
        self._window: deque[FloatArray] = deque(maxlen=settings.samples)
        channels = [shoe.channels[index] for index in shoe.of_foot(load.foot)]
        # Of a cell that bears the weight alone, the others may lie unplugged on the bench.
        self._wanted = np.array([not load.alone or one.name == load.place for one in channels])
        span = np.array([one.highest - one.lowest for one in channels])
        self._limit = settings.still_fraction * span
        self._before = last.mean if last is not None and _follows(last.load, load) else None

    def take(self, sample: FloatArray) -> StillState:
        """Take the foot's channels (k,) at one instant [unit]; NaN where one gave none."""
        self.taken += 1
        if np.isfinite(sample[self._wanted]).all():
            self._window.append(sample)
        else:
            self._window.clear()
        late = self.taken >= self._settings.patience
        if len(self._window) < self._settings.samples:
            return StillState.SILENT if late else StillState.UNDER_WAY
        if (self.std > self._limit)[self._wanted].any():
            return StillState.MOVED if late else StillState.UNDER_WAY
        if self._before is not None:
            change = np.abs(self.mean - self._before)
            if not (change > CHANGED * self._limit).any():
                return StillState.UNCHANGED if late else StillState.UNDER_WAY
        return StillState.STILL

    @property
    def gathered(self) -> int:
        """Samples in a row, up to those of a whole reading."""
        return len(self._window)

    @property
    def mean(self) -> FloatArray:
        """(k,) of the last samples [unit]."""
        mean: FloatArray = np.mean(self._window, axis=0)
        return mean

    @property
    def std(self) -> FloatArray:
        """(k,) of one sample among them [unit]."""
        std: FloatArray = np.std(self._window, axis=0, ddof=1)
        return std


def _follows(last: Load, load: Load) -> bool:
    """Whether the readings of both loads must differ: another weight or place on the same thing."""
    same_thing = last.place == load.place if load.alone or last.alone else last.foot == load.foot
    return same_thing and last != load
