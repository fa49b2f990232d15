"""The time offset between joints and readings, found where the CoP moves fast.

The model's error of the CoP is slow: in the change of the CoP within parts of a second there is
little of it, and the measured change follows the modelled one at once, or late. The offset is
    tau = sum (dC - dC_m) . dC_m' / sum dC_m' . dC_m'
over all samples, dC being the change within some time; long times first, since they bear large
offsets, then shorter ones, which are more exact.

An offset that grows along a run, tau + s t, is a clock that runs fast or slow. It is fitted by
    dC - dC_m = (tau + s t) dC_m' + M dC_m + a dC_m''
with what gains that are not known yet (M) and the body's acceleration (a) do to the CoP. Where the
clocks are not set between the runs, the runs' offsets grow by s, too, from the first to the last.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.samples.aligned import MIN_SAMPLES, Aligned
from shoecal_core.samples.filters import resampled, typical_period
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.noise import spread
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import cop

MAX_TIME_OFFSET_S = 0.05
"""Clocks of joints and readings that are further apart are named."""
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
PIECES = 6
"""Of a run: how far their offsets scatter about a line shows how sure its drift is."""
LEAST_APART_S = 2.0
"""Runs whose middles span less show no drift from one to the next."""
SLOPES = 7
"""Unknowns of that fit."""
BODY_DRIFT_S, BODY_OFFSET_S = 0.03, 0.03
"""Standard deviations over healthy runs of how the offset drifts within one, of any length and
common to a session, and of how it differs between them: gears and cells settle."""
LEAST_RUNS = 4
"""From which their offsets show whether they grow evenly."""
STEP_FACTOR = 2.0
"""Offsets of runs, or of pieces of one, scatter about a line by so many times less than where they
jump once."""
UNKNOWN = (0.0, 1e3)
"""A slope and its standard deviation where nothing shows it."""
LARGEST_RATE = 0.03
"""No clock is further off; a faster drift of the CoP has another cause."""
RATE_STDS = 3.0
"""Standard deviations from which a clock's rate is sure: 0.15 % in one run of a minute, 0.1 % in
seven runs within two."""


@dataclass(frozen=True)
class CopTrack:
    """Measured and modelled CoP of one run: (T,) times, (T, 2) each [m]."""

    time: FloatArray
    measured: FloatArray
    modelled: FloatArray


def time_offset(tracks: Mapping[int, CopTrack]) -> float:
    """Joints are late by so much [s]; 0 where it is little or the runs do not agree about it.

    Args:
        tracks: of each run, see `cop_tracks`.
    """
    if len(tracks) < 2:
        return 0.0
    late = late_of(list(tracks.values()))
    each = np.array([late_of([track], late) for track in tracks.values()])
    unsure = float(each.std(ddof=1) / np.sqrt(len(each)))
    return late if abs(late) > max(CORRECTED_S, SURE_STDS * unsure) else 0.0


def clock_rate(starts: Mapping[int, float], tracks: Mapping[int, CopTrack]) -> float:
    """Share by which the readings' clock runs faster than the joints'; 0 where both run alike.

    Args:
        starts: of the runs, by one clock [s].
        tracks: of each run by the stamps as they are, see `cop_tracks`.
    """
    within = _within(list(tracks.values()))
    between = _between(starts, tracks)
    slope, std = within
    if abs(between[0] - slope) < RATE_STDS * np.hypot(std, between[1]):
        share = np.array([one[1] ** -2.0 for one in (within, between)])
        slope = float(share @ (slope, between[0]) / share.sum())
        std = float(share.sum() ** -0.5)
    # Readings of a fast clock come later and later, so the joints earlier and earlier.
    return -slope if RATE_STDS * std < abs(slope) < LARGEST_RATE else 0.0


def _within(tracks: Sequence[CopTrack]) -> tuple[float, float]:
    """By how much the offset grows in a second within runs, and the standard deviation of that."""
    drifts = [_drift(track) for track in tracks]
    found = np.array([one for one in drifts if one is not None]).reshape(-1, 3)
    if not len(found):
        return UNKNOWN
    slopes, own, spans = found.T
    share = 1.0 / (own**2 + (BODY_DRIFT_S / spans) ** 2)
    share_of = share / share.sum()
    slope = float(share_of @ slopes)
    scatter = float(share @ (slopes - slope) ** 2) / max(1, len(slopes) - 1)
    unsure = np.sqrt(max(1.0, scatter) / share.sum())
    return slope, float(np.hypot(unsure, BODY_DRIFT_S * (share_of @ (1.0 / spans))))


def _between(starts: Mapping[int, float], tracks: Mapping[int, CopTrack]) -> tuple[float, float]:
    """The same from run to run, by the median over all pairs of runs."""
    if len(tracks) < LEAST_RUNS:
        return UNKNOWN
    late = np.array([late_of([track]) for track in tracks.values()])
    at = np.array([starts[run] + float(track.time.mean()) for run, track in tracks.items()])
    at -= at.mean()
    if np.ptp(at) < LEAST_APART_S or np.abs(late).max() >= LARGEST_S:
        return UNKNOWN
    first, second = np.triu_indices(len(at), 1)
    apart = at[second] - at[first]
    slope = float(np.median((late[second] - late[first])[apart != 0.0] / apart[apart != 0.0]))
    scatter = float(spread((late - slope * at).reshape(-1, 1))[0])
    return slope, max(STEP_FACTOR * scatter, BODY_OFFSET_S) / float(np.linalg.norm(at))


def _drift(track: CopTrack) -> tuple[float, float, float] | None:
    """By how much the offset of one run grows in a second, the standard deviation of that, and the
    run's length [s]; None of a run that is too short or still.
    """
    span = float(np.ptp(track.time))
    if span < 2.0 * SLOPES * CHANGES_S[0]:
        return None
    late, slope = late_of([track]), 0.0
    for change in CHANGES_S:
        rows, off, since = _equations(track, late, change, slope)
        size = np.maximum(np.abs(rows).max(axis=0), 1e-30)
        rows = rows / size
        solution, weight = _reweighed(rows, off)
        late, slope = late + float(solution[0] / size[0]), slope + float(solution[1] / size[1])
    left = off - rows @ solution
    # How far pieces of the run are off that line: one jump of the offset is no clock's rate.
    shown = weight * rows[:, 0] ** 2
    piece = _pieces(since, shown)
    total = np.bincount(piece, shown)
    if not (total > 0.0).all():
        return None
    apart = np.bincount(piece, weight * rows[:, 0] * left) / total / size[0]
    at = np.bincount(piece, shown * since) / total
    scatter = np.sqrt(apart @ apart / (PIECES - 2))
    return slope, float(STEP_FACTOR * scatter / np.linalg.norm(at - at.mean())), span


def _pieces(since: FloatArray, shown: FloatArray) -> IntArray:
    """(K,) which of PIECES pieces of time a change is in: each shows as much of the offset."""
    order = np.argsort(since, kind="stable")
    piece = np.empty(len(since), dtype=np.int64)
    piece[order] = np.minimum(
        np.cumsum(shown[order]) / max(shown.sum(), 1e-30) * PIECES, PIECES - 1
    )
    return piece


def _equations(
    track: CopTrack, late: float, change: float, slope: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """(2K, 7) what changes along x, then along y, answer to: offset, its slope, the four of M, the
    acceleration; (2K,) these changes; (2K,) their time since the middle of the run [s].
    """
    both, time = resampled(np.hstack((track.measured, track.modelled)), track.time)
    period = typical_period(time)
    count = max(1, round(change / period))
    since = time - 0.5 * (time[0] + time[-1])
    then = time + late + slope * since
    modelled = np.stack([np.interp(then, time, axis) for axis in both[:, 2:].T], axis=1)
    width = SMOOTHING * change / period
    placed, expected = (gaussian_filter1d(one, width, axis=0) for one in (both[:, :2], modelled))
    speed = np.gradient(expected, period, axis=0)
    pace = np.gradient(speed, period, axis=0)
    off, rate, moved, bend = (
        np.asarray(one[count:] - one[:-count]) for one in (placed - expected, speed, expected, pace)
    )
    since = since[count:] - 0.5 * change
    nothing = np.zeros_like(moved)
    rows = [
        np.column_stack((rate[:, axis], since * rate[:, axis], *own, bend[:, axis]))
        for axis, own in enumerate(((moved, nothing), (nothing, moved)))
    ]
    return np.concatenate(rows), off.T.ravel(), np.tile(since, 2)


def _reweighed(rows: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(u,) solution of rows (K, u) for values (K,) that outliers do not pull, and weights (K,)."""
    weight: FloatArray = np.ones(len(values))
    solution: FloatArray = np.zeros(rows.shape[1])
    for _ in range(REWEIGHED):
        normal = rows.T @ (weight[:, None] * rows) + _ridge(rows)
        solution = np.asarray(np.linalg.solve(normal, rows.T @ (weight * values)))
        weight = _weights(values - rows @ solution)
    return solution, weight


def _ridge(rows: FloatArray) -> FloatArray:
    """Added to a normal matrix of rows (K, u) of size one: what never moves stays where it is."""
    return 1e-12 * len(rows) * np.eye(rows.shape[1])


def _weights(left: FloatArray) -> FloatArray:
    """Of values by what is left of them: little where that is unusually much."""
    scale = 2.0 * float(spread(left.reshape(-1, 1))[0])
    weights: FloatArray = 1.0 / (1.0 + (left / max(scale, 1e-12)) ** 2)
    return weights


def cop_tracks(
    aligned: Mapping[int, Aligned], shoe: Shoe, weight: float, settings: CalibrationSettings
) -> dict[int, CopTrack]:
    """Measured and modelled CoP, by run.

    Args:
        aligned: runs in double support.
        weight: of robot and shoes [N].
    """
    if not aligned:
        return {}
    parts = {run: blocks(one, shoe) for run, one in aligned.items()}
    parameters = Statics.of(shoe, parts, weight, settings).fit.parameters
    tracks = {}
    for run, one in aligned.items():
        wrench = parameters.outputs(one.readings) @ parts[run].columns + parts[run].base
        place = cop(wrench, MINIMUM_FORCE)
        there = np.isfinite(place).all(axis=1)
        # A run in which hardly a foot was loaded does not show the clocks' offset.
        if there.sum() >= MIN_SAMPLES:
            tracks[run] = CopTrack(one.time[there], place[there], one.states.cop[there, 0])
    return tracks


def late_of(tracks: Sequence[CopTrack], start: float | None = None) -> float:
    """Joints of these runs are late by so much [s].

    From where that is known already, only the shortest changes are looked at.
    """
    late = 0.0 if start is None else start
    for change in CHANGES_S if start is None else CHANGES_S[-2:]:
        late = float(np.clip(late + _step(tracks, late, change), -LARGEST_S, LARGEST_S))
    return late


def _step(tracks: Sequence[CopTrack], late: float, change: float) -> float:
    """By how much the offset is still wrong."""
    off, rate = (
        np.concatenate(parts)
        for parts in zip(*(_changes(track, late, change) for track in tracks), strict=True)
    )
    weight = np.ones(off.shape)
    step = 0.0
    for _ in range(REWEIGHED):
        step = float((weight * off * rate).sum() / max((weight * rate * rate).sum(), 1e-30))
        weight = _weights(off - step * rate)
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


def describe_time_offset(time_offset: float) -> list[Finding]:
    """Joints and readings that are far apart in time; the fit is spared that."""
    if abs(time_offset) <= MAX_TIME_OFFSET_S:
        return []
    if abs(time_offset) >= 0.99 * LARGEST_S:
        return [
            Finding(
                "FAIL",
                f"joints and readings are {LARGEST_S:g} s apart or more, which is not corrected: "
                "let both be stamped when they are sampled, by one clock",
                Fault.LATE,
            )
        ]
    return [
        Finding(
            "WARN",
            f"joints are {'late' if time_offset > 0.0 else 'early'} by "
            f"{1e3 * abs(time_offset):.0f} ms against the readings, which is corrected in the fit: "
            "let both be stamped when they are sampled, by one clock"
            f"{'' if time_offset > 0.0 else ', and switch off filters in the device, which delay'}",
            Fault.LATE,
        )
    ]


def describe_clock_rate(rate: float) -> list[Finding]:
    """A clock that runs faster than the other one, which no constant offset puts right."""
    if rate == 0.0:
        return []
    return [
        Finding(
            "FAIL",
            f"the shoe's clock runs {100.0 * abs(rate):.2g}% {'fast' if rate > 0.0 else 'slow'} "
            "against the joints', so their stamps drift apart within each run: let both be stamped "
            "by one clock as they come in, or correct the clock of the board (its crystal or its "
            "timer's divider), and record again",
            Fault.LATE,
        )
    ]
