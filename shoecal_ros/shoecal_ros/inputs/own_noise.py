"""Has a cell's own noise ended? Then its converter or board hangs, and repeats what it gave last.

White noise of s counts, seen in whole counts while the force stays, makes one reading in so many a
strict extremum of three: 2/3 where s is large, 0.42 at one count, 0.35 at 0.7; with little noise at
most 1/4, where the force happens to lie between two counts. So a share of NOISY shows noise that
cannot rest wherever the force lies. Such a reading repeats with a chance of 0.37 or less: 25 times
in a row, one in 10^10. A converter that has not been seen to be noisy may rest for as long as it
likes: a motion makes no such share, a robot that shakes may, and then it must be seen again. So a
board whose noise is less than 0.7 counts looks like a robot that stands quite still.
"""

from __future__ import annotations

import math

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray

Cells = slice | IntArray
"""Some channels."""
ALL = slice(None)

NOISY = 0.35
"""Share of extrema from which noise is known."""
KNOWN_S = 5.0
"""Time constant of that share."""
ENDED_S, ENDED_FRAMES = 0.25, 25
"""Without a change for both, noise has ended."""


class OwnNoise:
    """Of n channels, each for itself.

    Attributes:
        noisy: (n,) whether a channel was seen to be noisy while the force stayed.
    """

    def __init__(self, count: int) -> None:
        """Nothing is known of so many channels."""
        self.noisy = np.zeros(count, dtype=bool)
        self._share = np.zeros(count)
        self._before = np.zeros(count)
        self._rest_s = np.zeros(count)
        self._rest_frames = np.zeros(count, dtype=np.int64)

    @property
    def ended(self) -> BoolArray:
        """(n,) whether a channel that was noisy is so no more."""
        long = (self._rest_s >= ENDED_S) & (self._rest_frames >= ENDED_FRAMES)
        ended: BoolArray = self.noisy & long
        return ended

    def take(self, steps: FloatArray, elapsed_s: float, cells: Cells = ALL) -> None:
        """Take (k, m) changes from reading to reading of m channels, over so long a time [s]."""
        changes = steps != 0.0
        changed = changes.any(axis=0)
        # What rests by nature, and was only shaken, is not reported again before it is known.
        thawed = self.ended[cells] & changed
        noisy, share = self.noisy[cells] & ~thawed, np.where(thawed, 0.0, self._share[cells])
        pairs = np.sign(np.concatenate([self._before[cells][None], steps]))
        extrema = np.mean(pairs[1:] * pairs[:-1] < 0.0, axis=0)
        share += (1.0 - math.exp(-elapsed_s / KNOWN_S)) * (extrema - share)
        self._share[cells], self.noisy[cells] = share, noisy | (share >= NOISY)
        since = np.argmax(changes[::-1], axis=0)
        rest_s = since * (elapsed_s / len(steps))
        self._rest_s[cells] = np.where(changed, rest_s, self._rest_s[cells] + elapsed_s)
        rest_frames = self._rest_frames[cells]
        self._rest_frames[cells] = np.where(changed, since, rest_frames + len(steps))
        self._before[cells] = steps[-1]
