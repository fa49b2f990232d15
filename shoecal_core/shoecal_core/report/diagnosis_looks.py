"""How a diagnosis looks in every figure: its two colours and the units of its signals."""

from __future__ import annotations

import math

from shoecal_core.report import palette

BEFORE = palette.Look(palette.RED, 1.1)
AFTER = palette.Look(palette.TEAL, 1.1)
_LENGTH, _ANGLE, _FORCE = (1e3, "mm"), (180.0 / math.pi, "°"), (1.0, "N")
_UNITS = {
    "grf": _FORCE, "cop": _LENGTH, "air_f": _FORCE, "air_m": (1.0, "N m"),
    "closure_roll": _ANGLE, "closure_pitch": _ANGLE, "closure_yaw": _ANGLE,
    "closure": _LENGTH, "parity": _FORCE, "tilt": _ANGLE,
}  # fmt: skip
"""By the beginning of a signal's name, the first that fits: factor and unit for a person."""


def unit_of(name: str) -> tuple[float, str]:
    """Factor and unit that a signal is shown in."""
    return next((unit for start, unit in _UNITS.items() if name.startswith(start)), (1.0, ""))
