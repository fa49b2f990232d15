"""Times whose decimals were printed as a number: 3.01 s as `3.10000000`, by `%d.%d`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray

EVEN = 3.0
"""Usual steps from the last row of a second to the first of the next, at most, where the decimals
are the parts of a second that they are taken for, and no count of rows."""
LEFT = 0.5
"""Steps that do not go forward even so, over those that now do, at most: of rows that repeat."""


@dataclass(frozen=True)
class UnpaddedTimes:
    """Times as they were meant.

    Attributes:
        times: (T,) in the unit that they were written in.
        digits: that the decimals should have.
        first: place of the first that was written without its zeros.
    """

    times: FloatArray
    digits: int
    first: int

    def describe(self, text: str, line: int) -> str:
        """What was done, for the text of the first and its line, and the cure."""
        return (
            f"times were printed without the decimals' leading zeros: {text} (line {line}) is read "
            f"as {self.times[self.first]:.{self.digits}f} (print decimals with `%0{self.digits}d`)"
        )


def unpadded(texts: Sequence[str], decimal: str) -> UnpaddedTimes | None:
    """Times written without leading zeros of their decimals; None where that is not sure.

    It is where no decimals begin with a zero although times go back within a second, and with
    these zeros they go forward, in steps as even over the seconds as within them.

    Args:
        texts: of T rows in their order.
        decimal: what stands before the decimals.
    """
    pattern = re.compile(rf"\s*(\d+){re.escape(decimal)}(0|[1-9]\d*)\s*")
    found = [pattern.fullmatch(text) for text in texts]
    if len(found) < 2 or None in found:
        return None
    parts = [(one[1], one[2]) for one in found if one is not None]
    digits = max(len(decimals) for _, decimals in parts)
    whole = np.array([float(second) for second, _ in parts])
    # As text, so that times are the nearest numbers to what was meant.
    written, meant = (
        np.array([float(f"{second}.{decimals:0>{width}}") for second, decimals in parts])
        for width in (1, digits)
    )
    same = np.diff(whole) == 0.0
    steps, usual = np.diff(meant), float(np.median(np.diff(meant)))
    mended = same & (np.diff(written) < 0.0) & (steps > 0.0)
    if not mended.any() or same.all() or (steps <= 0.0).sum() > LEFT * mended.sum():
        return None
    if float(np.median(steps[~same])) > EVEN * usual:
        return None
    return UnpaddedTimes(meant, digits, int(np.flatnonzero(meant != written)[0]))
