"""Places on a shoe's top plate where a known weight can stand."""

from __future__ import annotations

import string
from dataclasses import dataclass

import numpy as np
from shapely import MultiPoint, Point

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError
from shoecal_core.files import Fields

MIN_PITCH = 2e-3
"""m; holes nearer to each other than this are one hole."""


@dataclass(frozen=True)
class Holes:
    """The holes of one shoe: rows across the foot, columns along it.

    Attributes:
        names: row by row, `a1` first: the row's letter and the column's number.
        positions: (rows * columns, 2) in the sole frame [m].
        columns: holes in a row.
    """

    names: tuple[str, ...]
    positions: FloatArray
    columns: int

    def position(self, name: str) -> FloatArray:
        """Place (2,) of a hole in the sole frame [m]."""
        if name not in self.names:
            raise NameNotFoundError("hole", name, self.names)
        place: FloatArray = self.positions[self.names.index(name)]
        return place

    def walk(self) -> tuple[str, ...]:
        """Every hole once, each next to the one before: rows run forth and back."""
        rows = [
            self.names[start : start + self.columns]
            for start in range(0, len(self.names), self.columns)
        ]
        return tuple(
            name
            for index, row in enumerate(rows)
            for name in (row if index % 2 == 0 else reversed(row))
        )


def read_holes(block: Fields, cells: FloatArray) -> Holes:
    """Holes of one foot's block of a shoe file.

    Args:
        block: holds `holes: {x_m: [rows], y_m: [columns]}`.
        cells: (k, 2) places of the foot's channels [m].

    Raises:
        FileError: for holes on one spot, in another unit, or not between the cells.
    """
    fields = block.mapping("holes")
    fields.only("x_m", "y_m")
    rows, columns = (_line(fields, key) for key in ("x_m", "y_m"))
    if len(rows) > len(string.ascii_lowercase):
        raise fields.error("x_m", f"{len(rows)} rows; their letters end at z")
    positions = np.array([(x, y) for x in rows for y in columns])
    names = tuple(
        f"{letter}{number}"
        for letter in string.ascii_lowercase[: len(rows)]
        for number in range(1, len(columns) + 1)
    )
    # One six-axis sensor bears a weight anywhere; cells only between them.
    hull = MultiPoint(cells).convex_hull.buffer(1e-9)
    if np.ptp(cells, axis=0).max() > 0.0:
        for name, place in zip(names, positions, strict=True):
            if not hull.covers(Point(place)):
                raise block.error(
                    "holes",
                    f"{name} at ({place[0]:g}, {place[1]:g}) m is not between the cells, where "
                    "alone a weight stands safely; lengths are in m, in the sole frame",
                )
    return Holes(names, positions, len(columns))


def _line(fields: Fields, key: str) -> FloatArray:
    values = fields.array(key, (None,))
    if not len(values):
        raise fields.error(key, "is empty; list the places in m")
    if len(values) > 1 and np.diff(np.sort(values)).min() < MIN_PITCH:
        raise fields.error(key, f"two of its places are less than {MIN_PITCH:g} m apart")
    return values
