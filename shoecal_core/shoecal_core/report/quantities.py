"""Numbers with their units and uncertainties, as a person reads them."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING

from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.shoe import Shoe

if TYPE_CHECKING:
    # Plans have none, and start sooner without all that measured series need.
    from shoecal_core.estimation.series import Mae

UNKNOWN = "–"
SPACE = "\N{NO-BREAK SPACE}"
PLUS_MINUS = f"{SPACE}±{SPACE}"
LEAST_PERCENT = 0.005
"""Smaller shares are less than one per cent."""


def channel_units(shoe: Shoe, *, torque: bool) -> tuple[str, str]:
    """Units of a channel's output and of its gain; `1` for a plain ratio.

    A shoe whose readings are newtons gives torques in newton metres.
    """
    output = "N m" if torque else "N"
    reading = output if shoe.unit == "N" else shoe.unit
    return output, "1" if reading == output else f"{output}/{reading}"


def number(value: float, decimals: int) -> str:
    """A number with a true minus sign; a dash where it is not known."""
    if not math.isfinite(value):
        return UNKNOWN
    text = f"{value:.{decimals}f}"
    if float(text) == 0.0:
        text = text.removeprefix("-")
    return text.replace("-", "\N{MINUS SIGN}")


def true_minus(text: str) -> str:
    """A sentence whose negative numbers have true minus signs."""
    return re.sub(r"(?<![\w.\-])-(?=\d)", "\N{MINUS SIGN}", text)


def quantity(value: float, unit: str, decimals: int = 2) -> str:
    """A number and its unit."""
    return _with_unit(number(value, decimals), unit)


def uncertain(value: float, uncertainty: float, unit: str) -> str:
    """A number ± its uncertainty, to two digits of that, and the unit.

    Without a known uncertainty four digits are shown.
    """
    if not math.isfinite(value):
        return UNKNOWN
    known = math.isfinite(uncertainty) and uncertainty > 0.0
    size = uncertainty if known else abs(value)
    digits = 2 if known else 4
    decimals = 0 if size == 0.0 else max(0, digits - 1 - math.floor(math.log10(size)))
    spread = f"{PLUS_MINUS}{number(uncertainty, decimals)}" if known else ""
    return _with_unit(f"{number(value, decimals)}{spread}", unit)


def size(value: float, unit: str) -> str:
    """A standard deviation, a guess or the like, to two digits."""
    if not math.isfinite(value):
        return UNKNOWN
    decimals = 0 if value == 0.0 else max(0, 1 - math.floor(math.log10(abs(value))))
    return _with_unit(number(value, decimals), unit)


def percent(share: float) -> str:
    """A share for a person; a small one is not nothing, a large one not all."""
    if 0.0 < share < LEAST_PERCENT:
        return "< 1 %"
    if 1.0 - LEAST_PERCENT <= share < 1.0:
        return "> 99 %"
    return f"{number(100.0 * share, 0)} %"


def mean_error(mae: Mae, unit: str, scale: float = 1.0) -> str:
    """MAE ± the standard deviation of the absolute error, in a unit of 1/`scale`."""
    if not mae.count:
        return UNKNOWN
    mean, std = number(scale * mae.mean, 2), number(scale * mae.std, 2)
    return _with_unit(f"{mean}{PLUS_MINUS}{std}", unit)


def double_support_text(support: DoubleSupport) -> str:
    """Where the right foot stands, from the left."""
    return ", ".join(
        (
            f"x{SPACE}{quantity(1e3 * support.dx, 'mm', 0)}",
            f"y{SPACE}{quantity(1e3 * support.dy, 'mm', 0)}",
            f"yaw{SPACE}{quantity(math.degrees(support.dtheta), '°', 1)}",
        )
    )


def _with_unit(text: str, unit: str) -> str:
    """Plain ratios, whose unit is 1, stand without it; degrees stand close."""
    if text == UNKNOWN or unit == "1":
        return text
    return f"{text}{'' if unit == '°' else SPACE}{unit}"
