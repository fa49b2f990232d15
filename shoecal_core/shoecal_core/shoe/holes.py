"""Places on a shoe's top plate where a known weight can stand."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError


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
