"""Joint angles at the times of sensor readings."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import NameNotFoundError
from shoecal_core.recording.run import Floats, JointSamples


def interpolate_joints(
    joints: JointSamples,
    times: Floats,
    max_gap_s: float,
    *,
    late_s: float = 0.0,
    names: Sequence[str] | None = None,
) -> tuple[Floats, NDArray[np.bool_]]:
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
    # Joints that are told together share their sample times: one pass for each such set.
    told, member = np.unique(np.isfinite(samples), axis=1, return_inverse=True)
    for index in range(told.shape[1]):
        rows, columns = told[:, index], np.flatnonzero(member.reshape(-1) == index)
        position[:, columns] = _interpolate(
            joints.time[rows], samples[np.ix_(rows, columns)], wanted, max_gap_s
        )
    valid = np.isfinite(position).all(axis=1)
    position[~valid] = np.nan
    return position, valid


def _interpolate(time: Floats, values: Floats, wanted: Floats, max_gap_s: float) -> Floats:
    """Values (k, c) of times (k,) at wanted times (T,): (T, c), NaN in gaps and outside."""
    if len(time) == 0:
        return np.full((len(wanted), values.shape[1]), np.nan)
    left = np.clip(np.searchsorted(time, wanted, side="right") - 1, 0, len(time) - 1)
    right = np.minimum(left + 1, len(time) - 1)
    gap = time[right] - time[left]
    exact = wanted == time[left]
    inside = (wanted > time[0]) & (wanted < time[-1]) & (gap <= max_gap_s)
    fraction = np.where(exact, 0.0, (wanted - time[left]) / np.where(gap > 0.0, gap, 1.0))
    found = values[left] + fraction[:, None] * (values[right] - values[left])
    found[~(exact | inside)] = np.nan
    return found
