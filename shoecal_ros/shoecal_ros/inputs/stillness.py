"""Does the robot stand still? Judged by joint angles alone."""

from __future__ import annotations

from collections import deque

import numpy as np

from shoecal_core.arrays import FloatArray

SAMPLES = 2000
"""Samples closer together than the while over so many add nothing."""


class Stillness:
    """Still: over the last while no joint moved faster than allowed, steps of encoders aside."""

    def __init__(self, speed: float, duration_s: float, resolution: float) -> None:
        """Not known yet.

        Args:
            speed: mean over the while, of any joint [rad/s].
            duration_s: how long it must be so [s].
            resolution: changes up to this are no motion [rad].
        """
        self._duration_ns = round(duration_s * 1e9)
        self._span = speed * duration_s + resolution
        self._samples: deque[tuple[int, FloatArray]] = deque()

    def restart(self) -> None:
        """Forget what was: the robot has been commanded to move."""
        self._samples.clear()

    def add(self, stamp_ns: int, angles: FloatArray) -> None:
        """Take all joint angles (m,) [rad] of one instant; those that are NaN do not count."""
        samples = self._samples
        if samples and (stamp_ns <= samples[-1][0] or angles.shape != samples[-1][1].shape):
            self.restart()
        elif samples and stamp_ns - samples[-1][0] < self._duration_ns // SAMPLES:
            return
        samples.append((stamp_ns, angles))
        while len(samples) > 1 and stamp_ns - samples[1][0] >= self._duration_ns:
            samples.popleft()

    @property
    def still(self) -> bool:
        """Whether it stands still."""
        samples = self._samples
        if not samples or samples[-1][0] - samples[0][0] < self._duration_ns:
            return False
        angles = np.stack([sample for _, sample in samples])
        moved = np.ptp(angles[:, np.isfinite(angles).all(axis=0)], axis=0)
        return bool(moved.size) and bool((moved <= self._span).all())
