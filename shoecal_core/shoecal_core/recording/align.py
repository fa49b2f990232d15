"""Joint angles at the times of sensor readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.errors import NameNotFoundError
from shoecal_core.recording.run import JointSamples


def interpolate_joints(
    joints: JointSamples,
    times: FloatArray,
    max_gap_s: float,
    *,
    late_s: float = 0.0,
    names: Sequence[str] | None = None,
) -> tuple[FloatArray, BoolArray]:
    """Joint angles at given times, linearly between samples and never beyond them.

    Args:
        joints: as recorded.
        times: (T,) since the run's start [s].
        max_gap_s: samples further apart are not interpolated between [s].
        late_s: joint stamps are late by this much against `times`: an angle stamped t was
            true at t - late_s [s].
        names: joints wanted, in this order; all of them when None.

    Returns:
        position (T, m) [rad] and valid (T,): every wanted joint has an angle there. Rows that
        are not valid hold NaN.

    Raises:
        NameNotFoundError: for a joint that was not recorded.
    """
    names = joints.names if names is None else names
    for name in names:
        if name not in joints.names:
            raise NameNotFoundError("recorded joint", name, joints.names)
    samples = joints.position[:, [joints.names.index(name) for name in names]]
    wanted = np.asarray(times, dtype=np.float64) + late_s
    position = np.full((len(wanted), len(names)), np.nan)
    # Joints that are sampled together share their times: one pass for each such set.
    sampled, member = np.unique(np.isfinite(samples), axis=1, return_inverse=True)
    for index in range(sampled.shape[1]):
        rows, columns = sampled[:, index], np.flatnonzero(member.reshape(-1) == index)
        if rows.any():
            around = bracket(joints.time[rows], wanted, max_gap_s)
            position[:, columns] = around.interpolate(samples[np.ix_(rows, columns)])
    valid = np.isfinite(position).all(axis=1)
    position[~valid] = np.nan
    return position, valid


@dataclass(frozen=True)
class Bracket:
    """Where wanted times lie among samples.

    Attributes:
        before, after: (T,) places of the samples on either side; the same one where a sample is at
            the wanted time itself.
        fraction: (T,) of the way from `before` to `after`.
        valid: (T,) False in gaps and outside the samples' time.
    """

    before: IntArray
    after: IntArray
    fraction: FloatArray
    valid: BoolArray

    def interpolate(self, values: FloatArray) -> FloatArray:
        """Values (k, c) of the samples at the wanted times (T, c), same unit; NaN where invalid."""
        start = values[self.before]
        found = start + self.fraction[:, None] * (values[self.after] - start)
        found[~self.valid] = np.nan
        return found


def bracket(time: FloatArray, wanted: FloatArray, max_gap: float) -> Bracket:
    """The samples around wanted times.

    Args:
        time: (k,) of the samples, increasing; one or more.
        wanted: (T,) in the same unit.
        max_gap: samples further apart have nothing between them.
    """
    before = np.clip(np.searchsorted(time, wanted, side="right") - 1, 0, len(time) - 1)
    exact = wanted == time[before]
    after = np.where(exact, before, np.minimum(before + 1, len(time) - 1))
    gap = time[after] - time[before]
    inside = (wanted > time[0]) & (wanted < time[-1]) & (gap <= max_gap)
    fraction = np.where(exact, 0.0, (wanted - time[before]) / np.where(gap > 0.0, gap, 1.0))
    return Bracket(before, after, fraction, exact | inside)
