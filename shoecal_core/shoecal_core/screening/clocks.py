"""The time offset between joints and readings, found where the CoP moves fast.

The model's error of the CoP is slow: in the change of the CoP within parts of a second there is
little of it, and the measured change follows the modelled one at once, or late. The offset is
    tau = sum (dC - dC_m) . dC_m' / sum dC_m' . dC_m'
over all samples, dC being the change within some time; long times first, since they bear large
offsets, then shorter ones, which are more exact.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.samples.aligned import MIN_SAMPLES, Aligned
from shoecal_core.samples.filters import resampled, typical_period
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.noise import spread
from shoecal_core.screening.rough_fit import equations, prior, reweighed, solve
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import cop

CHANGES_S = (0.8, 0.8, 0.4, 0.4, 0.15, 0.15, 0.15)
"""Times over which changes are looked at, one after the other."""
SMOOTHING = 0.3
"""Of both CoPs, as a share of that time."""
LARGEST_S = 1.5
"""Offsets beyond this are not looked for."""
CORRECTED_S, SURE_STDS = 0.01, 3.0
"""An offset is corrected before the fit when it is larger than this, and this many of its own
standard deviations; the fit finds what is left."""
LEFT_STD_S = 0.005
"""How far a corrected offset may still be off."""
REWEIGHED = 5
DRIFTS_S = 0.05
"""Clocks of different rates are named from this drift within a run on."""
CONFIRMED = 0.5
"""Share of a clock's rate by which what the CoP shows of it may differ."""


@dataclass(frozen=True)
class CopTrack:
    """Measured and modelled CoP of one run: (T,) times, (T, 2) each [m]."""

    time: FloatArray
    measured: FloatArray
    modelled: FloatArray


def time_offset(
    aligned: Mapping[int, Aligned], shoe: Shoe, weight: float, settings: CalibrationSettings
) -> float:
    """Joints are late by so much [s]; 0 where it is little or the runs do not agree about it.

    Args:
        aligned: runs in double support.
        weight: of robot and shoes [N].
    """
    if len(aligned) < 2:
        return 0.0
    tracks = _tracks(aligned, shoe, weight, settings)
    if len(tracks) < 2:
        return 0.0
    late = _late(tracks)
    each = np.array([_late([track], late) for track in tracks])
    unsure = float(each.std(ddof=1) / np.sqrt(len(each)))
    return late if abs(late) > max(CORRECTED_S, SURE_STDS * unsure) else 0.0


def clock_rate(
    runs: Mapping[int, Run],
    aligned: Mapping[int, Aligned],
    shoe: Shoe,
    weight: float,
    settings: CalibrationSettings,
) -> float:
    """Share by which the readings' clock runs faster than the joints'; 0 where both run alike.

    What was recorded together spans other times, and the CoP confirms it: from the first half of
    each run to the second the joints get later, or earlier.

    Args:
        runs: by number.
        aligned: those in double support, by the stamps as they are.
        weight: of robot and shoes [N].
    """
    spans = [
        [float(np.ptp(one.time)) for one in (runs[run].readings, runs[run].joints)]
        for run in aligned
    ]
    rate = float(np.median([mine / other - 1.0 for mine, other in spans])) if spans else 0.0
    if not spans or abs(rate) * float(np.median(spans)) < DRIFTS_S:
        return 0.0
    shown = []
    for track in _tracks(aligned, shoe, weight, settings):
        first, second = _halves(track)
        if min(len(first.time), len(second.time)) >= MIN_SAMPLES:
            apart = float(second.time.mean() - first.time.mean())
            shown.append((_late([first]) - _late([second])) / apart)
    sure = bool(shown) and abs(float(np.median(shown)) - rate) < CONFIRMED * abs(rate)
    return rate if sure else 0.0


def _halves(track: CopTrack) -> tuple[CopTrack, CopTrack]:
    """One run's first half and its second."""
    early = track.time < 0.5 * (track.time[0] + track.time[-1])
    first, second = (
        CopTrack(track.time[part], track.measured[part], track.modelled[part])
        for part in (early, ~early)
    )
    return first, second


def _tracks(
    aligned: Mapping[int, Aligned], shoe: Shoe, weight: float, settings: CalibrationSettings
) -> list[CopTrack]:
    parts = {run: blocks(one, shoe) for run, one in aligned.items()}
    information = prior(shoe, parts, weight, settings)
    rows = {run: equations(one, weight, settings) for run, one in parts.items()}
    parameters = solve(reweighed(rows, information), information).parameters
    tracks = []
    for run, one in aligned.items():
        wrench = parameters.outputs(one.readings) @ parts[run].columns + parts[run].base
        place = cop(wrench, MINIMUM_FORCE)
        there = np.isfinite(place).all(axis=1)
        # A run in which hardly a foot was loaded does not show the clocks' offset.
        if there.sum() >= MIN_SAMPLES:
            tracks.append(CopTrack(one.time[there], place[there], one.states.cop[there, 0]))
    return tracks


def _late(tracks: list[CopTrack], start: float | None = None) -> float:
    """The offset; from where it is known already, only the shortest changes are looked at."""
    late = 0.0 if start is None else start
    for change in CHANGES_S if start is None else CHANGES_S[-2:]:
        late = float(np.clip(late + _step(tracks, late, change), -LARGEST_S, LARGEST_S))
    return late


def _step(tracks: list[CopTrack], late: float, change: float) -> float:
    """By how much the offset is still wrong."""
    off, rate = (
        np.concatenate(parts)
        for parts in zip(*(_changes(track, late, change) for track in tracks), strict=True)
    )
    weight = np.ones(off.shape)
    step = 0.0
    for _ in range(REWEIGHED):
        step = float((weight * off * rate).sum() / max((weight * rate * rate).sum(), 1e-30))
        left = off - step * rate
        scale = 2.0 * float(spread(left.reshape(-1, 1))[0])
        weight = 1.0 / (1.0 + (left / max(scale, 1e-12)) ** 2)
    return step


def _changes(track: CopTrack, late: float, change: float) -> tuple[FloatArray, FloatArray]:
    """(K, 2) measured less modelled change, and change of the modelled rate."""
    both, time = resampled(np.hstack((track.measured, track.modelled)), track.time)
    period = typical_period(time)
    count = max(1, round(change / period))
    modelled = np.stack([np.interp(time + late, time, axis) for axis in both[:, 2:].T], axis=1)
    width = SMOOTHING * change / period
    placed, expected = (gaussian_filter1d(one, width, axis=0) for one in (both[:, :2], modelled))
    rate = np.gradient(expected, period, axis=0)
    off = placed - expected
    return off[count:] - off[:-count], rate[count:] - rate[:-count]
