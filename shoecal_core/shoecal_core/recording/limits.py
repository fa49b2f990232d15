"""Joint angles compared with the joints' limits."""

from __future__ import annotations

import math

import numpy as np

from shoecal_core.arrays import FloatArray

BEYOND_RAD = 0.1
"""A joint whose zero is a little off misses its limits by less."""
FAR_RAD = 1.0
"""No joint is so far beyond its limits: its angles have another unit."""


def beyond_limits(joint: str, position: FloatArray, low: float, high: float) -> str:
    """What is beyond a joint's limits, in words; empty where nothing is.

    Args:
        joint: its name.
        position: (T,) one or more angles [rad].
        low, high: limits [rad].
    """
    beyond = _beyond(position, low, high)
    if beyond.max() <= BEYOND_RAD:
        return ""
    return (
        f"joint '{joint}' is at {position[np.argmax(beyond)]:.4g} rad, beyond its limits "
        f"{low:.4g} to {high:.4g} rad in the URDF"
    )


def in_degrees(position: FloatArray, low: float, high: float) -> bool:
    """Whether angles (T,) are far beyond limits [rad] that they are within as degrees."""
    return bool(
        high - low < math.tau  # joints without an end may have turned round and round
        and _beyond(position, low, high).max() > FAR_RAD
        and (_beyond(np.radians(position), low, high) < BEYOND_RAD).all()
    )


def _beyond(position: FloatArray, low: float, high: float) -> FloatArray:
    """How far angles (T,) are beyond limits; negative within."""
    return np.fmax(low - position, position - high)
