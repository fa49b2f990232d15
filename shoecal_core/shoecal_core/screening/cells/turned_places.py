"""Places of cells in another frame than the sole's: x to the right, or y forward, say.

A shoe file's places may come from a drawing whose axes are not forward and to the left. Turned by
right angles or mirrored, the places then fit the readings as they are, as no cables do.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import IntArray
from shoecal_core.screening.blocks import Blocks
from shoecal_core.screening.cells.wiring import CLEAR_SHARE, FITS
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics, moments_off, solve
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET

FEWEST = 3
"""Cells of a foot."""
BY_FRAME: Mapping[str, tuple[tuple[int, int], tuple[int, int]]] = {
    "[y, -x]": ((0, 1), (-1, 0)),
    "[-x, -y]": ((-1, 0), (0, -1)),
    "[-y, x]": ((0, -1), (1, 0)),
    "[x, -y]": ((1, 0), (0, -1)),
    "[-x, y]": ((-1, 0), (0, 1)),
    "[y, x]": ((0, 1), (1, 0)),
    "[-y, -x]": ((0, -1), (-1, 0)),
}
"""What to write in place of [x, y], and the rows of its matrix."""


@dataclass(frozen=True)
class TurnedPlaces:
    """Cells whose places fit in another frame.

    Attributes:
        feet: indices of those.
        written: what fits in place of [x, y].
        off, left: CoP off its model with the places as they are, and with those that fit [m].
    """

    feet: tuple[int, ...]
    written: str
    off: float
    left: float


def turned_places(statics: Statics) -> TurnedPlaces | None:
    """The frame, of both feet or of one, in which the places fit; None without."""
    shoe = statics.shoe
    cells = shoe.columns[:, 0] == 1.0
    own = [np.flatnonzero(cells & (shoe.foot == foot)) for foot in range(len(FEET))]
    if min(len(one) for one in own) < FEWEST:
        return None
    tried = {}
    for feet in ((0, 1), (0,), (1,)):
        for written, rows in BY_FRAME.items():
            tried[feet, written] = _fit(statics, [own[foot] for foot in feet], np.array(rows))
    now = _fit(statics, [], np.eye(2, dtype=int))
    best = min(tried, key=lambda one: tried[one][0])
    cost, left = tried[best]
    count = sum(one.sums().count for one in statics.rows.values())
    if cost > min(CLEAR_SHARE * now[0], FITS * count):
        return None
    return TurnedPlaces(*best, off=now[1], left=left)


def _fit(statics: Statics, cells: Sequence[IntArray], frame: IntArray) -> tuple[float, float]:
    """Sum of squares, and how far the CoP is off (RMS) [m], with places in another frame.

    Args:
        cells: (k,) indices of each foot whose places are.
        frame: (2, 2) by which they are turned.
    """
    columns, places = statics.shoe.columns, statics.shoe.positions @ frame.T
    turned = np.column_stack((columns[:, 0], places[:, 1], -places[:, 0]))

    def change(blocks: Blocks) -> Blocks:
        changed = blocks.columns.copy()
        for own in cells:
            # From the foot's frame to that of the equations, where the foot stands in this run.
            carried = np.linalg.lstsq(columns[own], changed[own], rcond=None)[0]
            changed[own] = turned[own] @ carried
        return replace(blocks, columns=changed)

    there = statics.changed(change)
    fit = solve(there.rows, there.information)
    return fit.cost, statics.settings.cop_std_m * moments_off(there.rows.values(), fit.vector)


def describe_turned_places(found: TurnedPlaces | None) -> list[Finding]:
    """Places in another frame."""
    if found is None:
        return []
    feet = " and ".join(FEET[foot] for foot in found.feet)
    return [
        Finding(
            "FAIL",
            f"the places of the {feet} foot's cells fit in another frame: the CoP is "
            f"{1e3 * found.off:.0f} mm off its model, and {1e3 * found.left:.1f} mm with "
            f"{found.written} in place of [x, y] of every 'position_m' in the shoe file (x "
            "forward, y to the left); correct them, or exchange cells and cables that fit so",
            Fault.SWAPPED,
        )
    ]
