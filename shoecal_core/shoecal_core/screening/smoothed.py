"""Readings that were smoothed, off line or by the device, so that quick changes of the CoP lack.

The CoP by the joint angles is smoothed until it changes like the measured one. Gains that are not
known yet scale and turn the change, so that is fitted along: what counts is how little is left with
the best width, against none.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from scipy.ndimage import gaussian_filter1d

from shoecal_core.arrays import FloatArray
from shoecal_core.samples.filters import resampled, typical_period
from shoecal_core.screening.clocks import CopTrack, late_of
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding

WIDTHS_S = (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.2, 1.5, 2.0)
"""Standard deviations of the filters that are tried. A mean over a second has 0.29."""
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
smoothed by 0.6 s and more: 0.04 to 0.27; sound ones, simulated and real: 1.0."""


def smoothed_by(tracks: Mapping[int, CopTrack]) -> float:
    """Standard deviation of the filter that the readings went through [s]; 0 where it is narrow.

    Args:
        tracks: of each run, see `cop_tracks`.
    """
    widths = [_width(track) for track in tracks.values()]
    width = float(np.median(widths)) if widths else 0.0
    return width if width >= HARMLESS_S else 0.0


def _width(track: CopTrack) -> float:
    """Of one run; 0 where none explains it."""
    late = late_of([track])
    both, time = resampled(np.hstack((track.measured, track.modelled)), track.time)
    period = typical_period(time)
    modelled = np.stack([np.interp(time + late, time, axis) for axis in both[:, 2:].T], axis=1)
    calm = _smooth(np.hstack((both[:, :2], modelled)), CALM_S, period)
    every = max(1, int(CALM_S / period))
    calm, period = calm[::every], every * period
    placed = _quick(calm[:, :2], period)
    left = [
        _left(placed, _quick(_smooth(calm[:, 2:], width, period), period)) for width in WIDTHS_S
    ]
    best = int(np.argmin(left))
    return WIDTHS_S[best] if left[best] < LEFT * left[0] else 0.0


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


def describe_smoothed(width: float) -> list[Finding]:
    """Readings that lack what is quick, by the width of `smoothed_by` [s]."""
    if width == 0.0:
        return []
    return [
        Finding(
            "FAIL" if width >= REFUSED_S else "WARN",
            f"readings are smoothed, as by a filter with a standard deviation of {width:.1f} s: "
            "quick changes of the CoP that the joint angles show are missing in them; record or "
            "export them raw (switch the filter off)",
            Fault.SMOOTHED,
        )
    ]
