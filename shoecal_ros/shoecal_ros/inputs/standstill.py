"""Collects what a robot sends while it stands still."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.schemas import GOOD
from shoecal_core.shoe.sensing import Sensing
from shoecal_ros.inputs.joining import Joined
from shoecal_ros.inputs.joints import JointBatch

UNREST_N = 1.0
"""Where the force on the floor varies by more, something touches the robot."""


class Standstill:
    """Readings and joint angles of a robot that stands still.

    Attributes:
        bad: channels that gave a reading that is not good, by index.
    """

    def __init__(self, duration_s: float, least: int = 1) -> None:
        """Nothing has come.

        Args:
            duration_s: from the first to the last reading [s].
            least: number of readings.
        """
        self._duration_ns = round(duration_s * 1e9)
        self._least = least
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
        enough = len(stamps) >= self._least and len(self._angles) > 0
        return enough and stamps[-1] - stamps[0] >= self._duration_ns

    def take_readings(self, joined: Sequence[Joined]) -> None:
        """Take readings in order; those that came before count once."""
        for one in joined:
            if self._stamps and one.stamp_ns == self._stamps[-1]:
                continue
            self.bad |= set(np.flatnonzero(one.status != GOOD).tolist())
            self._stamps.append(one.stamp_ns)
            self._readings.append(one.readings)

    def take_joints(self, batch: JointBatch) -> None:
        """Take joint angles in order."""
        self._angles.append(batch.angles)

    @property
    def readings(self) -> FloatArray:
        """(n,) mean, in the readings' unit."""
        mean: FloatArray = np.mean(self._readings, axis=0)
        return mean

    @property
    def angles(self) -> FloatArray:
        """(m,) mean [rad]."""
        mean: FloatArray = np.concatenate(self._angles).mean(axis=0)
        return mean

    def unrest(self, sensing: Sensing) -> float:
        """Standard deviation of the force on both feet [N]."""
        return float(sensing.measure(np.stack(self._readings)).total_grf.std())
