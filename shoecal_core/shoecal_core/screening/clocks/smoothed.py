"""Readings that were smoothed, off line or by the device, so that quick changes of the CoP lack.

The CoP by the joint angles is smoothed until it changes like the measured one: by a filter that
looks both ways, and by one of first order that looks back, as firmware has (y += a (x - y)), whose
delay is found along. Gains that are not known yet scale and turn the change, so that is fitted,
too: what counts is how little is left with the best filter, against none.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from shoecal_core.arrays import FloatArray
from shoecal_core.samples.filters import first_order, resampled, typical_period
from shoecal_core.screening.clocks.time_offsets import CopTrack, late_of
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding

WIDTHS_S = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.2, 1.5, 2.0)
"""Standard deviations of the filters that are tried. A mean over a second has 0.29."""
CONSTANTS_S = (0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.4, 2.0)
"""Time constants of those of first order: their standard deviations, too."""
HARMLESS_S, REFUSED_S = 0.5, 0.7
"""Narrower ones than the first are not reported, from the second on they are refused. Measured on
Wren and NAO: a calibration of sound ones moves the CoP by 0.2 mm RMS at 0.45 s, 0.6 mm at 0.6 s; at
0.8 s the expected error of the CoP grows from 1.1 to 1.9 mm."""
SLOW_S = 1.0
"""What is slower than this is left out: the model's own errors are slow."""
CALM_S = 0.05
"""Noise of the readings is faster than this."""
LEFT = 0.5
"""With the best width less than this share is left of what no width leaves. Simulated recordings
smoothed by 0.6 s and more: 0.04 to 0.27, by a first order of 1 s 0.35 to 0.40; sound ones,
simulated and real: 1.0."""


@dataclass(frozen=True)
class Smoothing:
    """A filter that readings went through.

    Attributes:
        width: standard deviation [s]; of one that looks back its time constant.
        back: it looks back only, as the device's own does.
    """

    width: float
    back: bool = False


NONE = Smoothing(0.0)
FILTERS = (
    NONE,
    *(Smoothing(width) for width in WIDTHS_S),
    *(Smoothing(width, back=True) for width in CONSTANTS_S),
)


def smoothing(tracks: Mapping[int, CopTrack]) -> Smoothing | None:
    """The filter that the readings of all runs went through; None where it is narrow.

    Args:
        tracks: of each run, see `cop_tracks`.
    """
    if not tracks:
        return None
    left = np.median([_each_left(track) for track in tracks.values()], axis=0)
    best = int(np.argmin(left))
    return FILTERS[best] if left[best] < LEFT and FILTERS[best].width >= HARMLESS_S else None


def _each_left(track: CopTrack) -> FloatArray:
    """(F,) what each filter leaves of one run, over what none leaves."""
    both, time = resampled(np.hstack((track.measured, track.modelled)), track.time)
    even = CopTrack(time, both[:, :2], both[:, 2:])
    late = late_of([even])
    left = np.array([_left_by(one, even, late) for one in FILTERS])
    return np.asarray(left / left[0])


def _left_by(one: Smoothing, track: CopTrack, late: float) -> float:
    """What a filter leaves; one that looks back makes up for a part of the delay."""
    period = typical_period(track.time)
    modelled = _smooth(track.modelled, one.width, period)
    if one.back:
        modelled = first_order(track.modelled, one.width, period)
        late = late_of([replace(track, modelled=modelled)])
    shifted = np.stack(
        [np.interp(track.time + late, track.time, axis) for axis in modelled.T], axis=1
    )
    calm = _smooth(np.hstack((track.measured, shifted)), CALM_S, period)
    every = max(1, int(CALM_S / period))
    quick = _quick(calm[::every], every * period)
    return _left(quick[:, :2], quick[:, 2:])


def _left(placed: FloatArray, expected: FloatArray) -> float:
    """Root mean square of what no scales and turns of the expected (T, 2) make of the placed."""
    scale, *_ = np.linalg.lstsq(expected, placed, rcond=None)
    return float(np.sqrt(np.mean((placed - expected @ scale) ** 2)))


def _quick(values: FloatArray, period: float) -> FloatArray:
    """What changes within seconds."""
    return values - _smooth(values, SLOW_S, period)


def _smooth(values: FloatArray, width: float, period: float) -> FloatArray:
    smooth: FloatArray = gaussian_filter1d(values, width / period, axis=0) if width else values
    return smooth


def describe_smoothed(found: Smoothing | None) -> list[Finding]:
    """Readings that lack what is quick."""
    if found is None:
        return []
    kind = (
        f"a low-pass of first order with a time constant of {found.width:.1f} s (an exponential "
        "mean, or a low rate's filter)"
        if found.back
        else f"a filter with a standard deviation of {found.width:.1f} s"
    )
    return [
        Finding(
            "FAIL" if found.width >= REFUSED_S else "WARN",
            f"readings are smoothed, as by {kind}: quick changes of the CoP that the joint angles "
            "show are missing in them; record or export them raw (switch the filter off)",
            Fault.SMOOTHED,
        )
    ]
