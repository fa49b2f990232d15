"""Collects a standstill for correcting offsets."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shoecal_ros.joining import Joined
from shoecal_ros.joints import JointBatch
from shoecal_ros.live import GOOD

FloatArray = NDArray[np.float64]


class Standstill:
    """Readings and joint angles of a robot that stands still.

    Attributes:
        bad: channels that gave a reading that is not good, by index.
    """

    def __init__(self, duration_s: float) -> None:
        self._duration_ns = round(duration_s * 1e9)
        self.restart()

    def restart(self) -> None:
        """Forget what has come: the robot has moved."""
        self.bad: set[int] = set()
        self._stamps: list[int] = []
        self._readings: list[FloatArray] = []
        self._angles: list[FloatArray] = []

    @property
    def done(self) -> bool:
        """Whether enough has come."""
        stamps = self._stamps
        return bool(stamps and self._angles) and stamps[-1] - stamps[0] >= self._duration_ns

    def take_readings(self, joined: Sequence[Joined]) -> None:
        """Take readings in order."""
        for one in joined:
            self.bad |= set(np.flatnonzero(one.status != GOOD).tolist())
            self._stamps.append(one.stamp_ns)
            self._readings.append(one.readings)

    def take_joints(self, batch: JointBatch) -> None:
        """Take joint angles in order."""
        self._angles.append(batch.angles)

    @property
    def readings(self) -> FloatArray:
        """(n,) mean."""
        mean: FloatArray = np.mean(self._readings, axis=0)
        return mean

    @property
    def angles(self) -> FloatArray:
        """(m,) mean [rad]."""
        mean: FloatArray = np.concatenate(self._angles).mean(axis=0)
        return mean
