"""First-order lags, moved on exactly while what they follow goes straight from value to value."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray


def relaxed(
    level: FloatArray, before: FloatArray, now: FloatArray, span: float, time: FloatArray | float
) -> FloatArray:
    """Where lags stand after a span.

    Of time y' = u - y, with u = before + (now - before) t / span:
    y(span) = e y(0) + (p - e) before + (1 - p) now, where a = span / time, e = exp(-a) and
    p = (1 - e) / a.

    Args:
        level: (...) where they stood.
        before, now: (...) what they follow, at the start and at the end of the span.
        span: [s].
        time: (...) their time constants [s].
    """
    if span <= 0.0:
        return level
    ratio = span / np.asarray(time)
    kept = np.exp(-ratio)
    mean = (1.0 - kept) / ratio
    new: FloatArray = kept * level + (mean - kept) * before + (1.0 - mean) * now
    return new
