"""How a diagnosis looks in every figure: its two colours and the units of its signals."""

from __future__ import annotations

import math

from shoecal_core.report import palette

BEFORE = palette.Look(palette.RED, 1.1)
AFTER = palette.Look(palette.TEAL, 1.1)
_UNITS = {"grf": (1.0, "N"), "cop": (1e3, "mm"), "air_f": (1.0, "N"), "air_m": (1.0, "N m"),
          "closure_x": (1e3, "mm"), "closure_y": (1e3, "mm"), "closure_z": (1e3, "mm"),
          "closure": (180.0 / math.pi, "°"), "parity": (1.0, "N"),
          "tilt": (180.0 / math.pi, "°")}  # fmt: skip
"""By the beginning of a signal's name: factor and unit for a person."""


def unit_of(name: str) -> tuple[float, str]:
    """Factor and unit that a signal is shown in."""
    return next((unit for start, unit in _UNITS.items() if name.startswith(start)), (1.0, ""))
