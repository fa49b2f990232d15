"""Directions of gains and offsets in plain words."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.shoe.shoe import FEET, Shoe

_KINDS = ("gains", "offsets")
_ENOUGH = 0.7
"""Part of a direction that its description must name."""
_MOST = 3
"""Parts named at most."""
_ALONE = 3.0
"""A foot that has so many times the other's part has it alone."""

_LEVEL, _FORE_AFT, _SIDEWAYS, _REST = range(4)


def describe_direction(shoe: Shoe, direction: FloatArray) -> str:
    """What a direction changes, most first: "the difference of the offsets between the feet", say.

    Args:
        shoe: with n channels.
        direction: (2n,) of relative gains, then offsets in units of one typical load.
    """
    count = len(shoe.channels)
    if direction.shape != (2 * count,):
        raise ShapeError("direction", f"({2 * count},)", direction.shape)
    parts = _by_pattern(shoe, direction) if _has_cells_only(shoe) else _by_channel(shoe, direction)
    parts.sort(key=lambda part: -part[0])
    whole = float(direction @ direction)
    named, names = 0.0, []
    for energy, name in parts[:_MOST]:
        if named >= _ENOUGH * whole:
            break
        named += energy
        names.append(name)
    return " with ".join(names)


def _has_cells_only(shoe: Shoe) -> bool:
    return bool((shoe.columns[:, 0] == 1.0).all())


def _by_channel(shoe: Shoe, direction: FloatArray) -> list[tuple[float, str]]:
    names = [f"the {kind[:-1]} of {name}" for kind in _KINDS for name in shoe.names]
    return [(float(part) ** 2, name) for part, name in zip(direction, names, strict=True)]


def _by_pattern(shoe: Shoe, direction: FloatArray) -> list[tuple[float, str]]:
    """Energy and name of each pattern of gains and offsets over the cells of both feet."""
    cells = [shoe.of_foot(foot) for foot in (0, 1)]
    found = []
    for kind, values in zip(_KINDS, np.split(direction, 2), strict=True):
        left, right = (_foot_patterns(shoe.positions[own], values[own]) for own in cells)
        found += [
            (float(one**2 + other**2), _name(kind, pattern, one, other))
            for pattern, (one, other) in enumerate(zip(left, right, strict=True))
        ]
    return found


def _foot_patterns(positions: FloatArray, values: FloatArray) -> FloatArray:
    """(4,) of one foot's values (k,): level, fore-aft, sideways, and the length of the rest."""
    axes = np.column_stack((np.ones(len(positions)), positions))
    basis, triangle = np.linalg.qr(axes)
    # Each part is positive where the values grow with its own axis.
    parts = (basis.T @ values) * np.sign(np.diag(triangle))
    rest = values - basis @ (basis.T @ values)
    return np.append(parts, np.linalg.norm(rest))


def _name(kind: str, pattern: int, left: float, right: float) -> str:
    alone = max(abs(left), abs(right)) > _ALONE * min(abs(left), abs(right))
    foot = FEET[int(abs(right) > abs(left))]
    alike = left * right > 0.0
    if pattern == _LEVEL:
        if alone:
            return f"the level of the {kind} of the {foot} foot"
        if alike:
            return f"the common level of all {kind}"
        return f"the difference of the {kind} between the left and the right foot"
    if pattern == _REST:
        return f"{kind} that cancel within {f'the {foot}' if alone else 'each'} foot"
    if alone:
        where = f"in the {foot} foot"
    else:
        where = "in both feet" if alike else "in opposite ways in the two feet"
    cells = "front against the rear" if pattern == _FORE_AFT else "left against the right"
    return f"the {kind} of the {cells} cells {where}"
