"""The CoP correction of one foot (paper, eqs. 4 and 5).

The corrected CoP is p = p0 + (X a', Y b') with, for a raw CoP p0 = (x, y) and outputs f,
X = (x^2, x, y, 1, f) and Y = (y^2, y, x, 1, f): linear in its parameters. The outputs f are those
of the foot's cells, or its six-axis sensor's vertical force and two moments.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import mul
from typing import TypeVar

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.shoe.shoe import FEET, Shoe

N = TypeVar("N", float, FloatArray)
"""The value at one instant, or an array of many: the same equations serve both."""
ROUNDING = 1e-9
"""Of a range: what it was trained on is not outside because it was summed in another order."""
POLYNOMIAL = 4
"""Terms of the second-order polynomial in one direction."""


@dataclass(frozen=True)
class CopCorrection:
    """Correction of one foot, and where it was trained.

    Attributes:
        foot: index into FEET.
        x: (4 + k,) a1..a4 and m1..mk of eq. 5, for the foot's k `corrected_channels`.
        y: (4 + k,) b1..b4 and n1..nk.
        cop_range: (2, 2) lowest and highest raw CoP trained on, sole frame [m].
        output_range: (2, k) lowest and highest channel outputs trained on [N or N m].
    """

    foot: int
    x: FloatArray
    y: FloatArray
    cop_range: FloatArray
    output_range: FloatArray

    def __post_init__(self) -> None:
        if self.foot not in (0, 1):
            raise ShoecalError(f"a correction's foot must be one of {', '.join(FEET)}")
        if self.x.ndim != 1 or len(self.x) < POLYNOMIAL:
            raise ShapeError("correction x", f"({POLYNOMIAL} + k,)", self.x.shape)
        for name, part, shape in (
            ("y", self.y, self.x.shape),
            ("cop_range", self.cop_range, (2, 2)),
            ("output_range", self.output_range, (2, self.channels)),
        ):
            if part.shape != shape:
                raise ShapeError(f"correction {name}", str(shape), part.shape)
        for part in (self.x, self.y, self.cop_range, self.output_range):
            if not np.isfinite(part).all():
                raise ShoecalError("the CoP correction holds a number that is not finite")

    @property
    def channels(self) -> int:
        """Number k of channels with a term."""
        return len(self.x) - POLYNOMIAL

    def correct(self, raw: Sequence[N], outputs: Sequence[N]) -> tuple[N, N]:
        """Corrected CoP x, y of one instant, or of many at once.

        Args:
            raw: x and y of the raw CoP [m], each a number or an array (...).
            outputs: k of the channels [N or N m], alike.
        """
        (x, y), (of_x, of_y) = raw, self._lines
        return x + _shift(of_x, x, y, outputs), y + _shift(of_y, y, x, outputs)

    def extrapolates(self, raw: Sequence[N], outputs: Sequence[N]) -> bool | BoolArray:
        """One or (...,): True outside the places and loads it was trained on.

        Args:
            raw, outputs: as of `correct`.
        """
        outside: bool | BoolArray = False
        for value, (low, high) in zip((*raw, *outputs), self._ranges, strict=True):
            outside |= (value < low) | (value > high)
        return outside

    @cached_property
    def _lines(self) -> tuple[list[float], list[float]]:
        # For one instant, plain numbers are much faster than arrays.
        return self.x.tolist(), self.y.tolist()

    @cached_property
    def _ranges(self) -> list[tuple[float, float]]:
        low, high = np.hstack((self.cop_range, self.output_range))
        rounded = ROUNDING * (high - low)
        return list(zip((low - rounded).tolist(), (high + rounded).tolist(), strict=True))


def corrected_channels(shoe: Shoe, foot: int) -> IntArray:
    """Indices (k,) of a foot's channels that the correction has a term for: no sideways forces."""
    felt = shoe.vertical | shoe.torque
    return np.flatnonzero(felt & (shoe.foot == foot))


def check_corrections(shoe: Shoe, corrections: Sequence[CopCorrection]) -> None:
    """Refuse corrections that are not of this shoe.

    Raises:
        ShapeError: for another number of channels.
        ShoecalError: for two corrections of one foot.
    """
    for index, correction in enumerate(corrections):
        count = len(corrected_channels(shoe, correction.foot))
        if correction.channels != count:
            raise ShapeError(
                f"correction of the {FEET[correction.foot]} foot",
                f"{POLYNOMIAL} + {count}",
                correction.x.shape,
            )
        if any(correction.foot == other.foot for other in corrections[:index]):
            raise ShoecalError(
                f"the {FEET[correction.foot]} foot has two CoP corrections; keep one"
            )


def _shift(line: Sequence[float], along: N, across: N, outputs: Sequence[N]) -> N:
    """Eq. 5 in one direction [m]."""
    square, straight, side, constant = line[:POLYNOMIAL]
    shift = square * along * along + straight * along + side * across + constant
    by_outputs: N = sum(map(mul, line[POLYNOMIAL:], outputs))
    return shift + by_outputs


def features(raw: FloatArray, outputs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Terms (..., 4 + k) of the x and of the y correction."""
    x, y = raw[..., 0], raw[..., 1]
    one = np.ones_like(x)

    def terms(along: FloatArray, across: FloatArray) -> FloatArray:
        polynomial = np.stack((along**2, along, across, one), axis=-1)
        return np.concatenate((polynomial, outputs), axis=-1)

    return terms(x, y), terms(y, x)
