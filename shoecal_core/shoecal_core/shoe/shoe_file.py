"""The file of a pair of force-sensing shoes: read, and checked for what no shoe can be."""

from __future__ import annotations

import string
from pathlib import Path

import numpy as np
from shapely import MultiPoint, Point

from shoecal_core.arrays import FloatArray
from shoecal_core.files import Fields, read_yaml, sha256
from shoecal_core.shoe.holes import Holes
from shoecal_core.shoe.shoe import (
    AXES,
    FEET,
    NO_PLATES,
    Channel,
    Plates,
    Shoe,
    axis_column,
    cell_column,
)

FORMAT = 1
MIN_CELL_SPREAD = 5e-3
"""m; cells nearer to one line than this cannot measure a CoP."""
MAX_DISTANCE = 1.0
"""m; anything further away is a place given in millimetres."""
MIN_PITCH = 2e-3
"""m; holes nearer to each other than this are one hole."""


def load_shoe(path: Path, *, partial: bool = False) -> Shoe:
    """Read a shoe file.

    Args:
        path: of the file.
        partial: accept a single shoe, and feet whose channels give a force but no CoP. That is
            enough for a manual calibration; a robot that calibrates itself needs all.

    Raises:
        FileError: for anything missing, mistyped or physically impossible, and unless `partial`
            for a missing foot, cells on one line and fewer than three channels a foot.
    """
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only("format", "name", "unit", "height_m", "converter", "feet")
    converter = fields.mapping("converter")
    converter.only("lowest", "highest")
    span = (converter.number("lowest"), converter.number("highest"))
    if span[0] >= span[1]:
        raise converter.error("lowest", "must be below 'highest'")
    feet = fields.mapping("feet")
    feet.only(*FEET)
    channels: list[Channel] = []
    plates: list[Plates] = []
    holes: list[Holes | None] = []
    for index, foot in enumerate(FEET):
        if partial and foot not in feet and FEET[1 - index] in feet:
            plates.append(NO_PLATES)
            holes.append(None)
            continue
        if foot not in feet:
            raise feet.error(
                foot,
                "is missing; add it (a single shoe can be calibrated by `shoecal manual` only)",
            )
        block = feet.mapping(foot)
        block.only("plates", "cells", "six_axis", "holes")
        plates.append(_plates(block.mapping("plates")))
        found = _cells(block, index, span) if "cells" in block else []
        if "six_axis" in block:
            found += _six_axis(block.mapping("six_axis"), index, span)
        if not partial:
            _check_cop(block, found)
        _check_names(block, found)
        channels += found
        places = np.array([channel.position for channel in found])
        holes.append(_holes(block, places) if "holes" in block else None)
    return Shoe(
        name=fields.text("name"),
        unit=fields.text("unit"),
        height=fields.number("height_m", minimum=0.0, maximum=MAX_DISTANCE),
        channels=tuple(channels),
        plates=(plates[0], plates[1]),
        path=Path(path),
        digest=sha256(path),
        holes=(holes[0], holes[1]),
    )


def _plates(fields: Fields) -> Plates:
    fields.only("mass_above_kg", "com_above_m", "mass_below_kg", "com_below_m")
    return Plates(
        mass_above=fields.number("mass_above_kg", minimum=0.0),
        com_above=_place(fields, "com_above_m", 3),
        mass_below=fields.number("mass_below_kg", minimum=0.0),
        com_below=_place(fields, "com_below_m", 3),
    )


def _cells(block: Fields, foot: int, span: tuple[float, float]) -> list[Channel]:
    channels = []
    for cell in block.items("cells"):
        cell.only("name", "position_m", "polarity", "nominal_gain")
        position = _place(cell, "position_m", 2)
        channels.append(
            Channel(
                name=f"{FEET[foot]}/{cell.text('name')}",
                foot=foot,
                column=cell_column(position),
                position=position,
                torque=False,
                polarity=_polarity(cell),
                nominal_gain=_nominal_gain(cell),
                lowest=span[0],
                highest=span[1],
            )
        )
    return channels


def _six_axis(block: Fields, foot: int, span: tuple[float, float]) -> list[Channel]:
    block.only("origin_m", "axes")
    origin = _place(block, "origin_m", 3)
    channels = []
    for axis in block.items("axes"):
        axis.only("axis", "polarity", "nominal_gain")
        name = axis.choice("axis", dict.fromkeys(AXES))
        channels.append(
            Channel(
                name=f"{FEET[foot]}/{name}",
                foot=foot,
                column=axis_column(name, origin),
                position=origin[:2],
                torque=name.startswith("m"),
                polarity=_polarity(axis),
                nominal_gain=_nominal_gain(axis),
                lowest=span[0],
                highest=span[1],
            )
        )
    return channels


def _place(fields: Fields, key: str, size: int) -> FloatArray:
    place = fields.array(key, (size,))
    if np.abs(place).max() > MAX_DISTANCE:
        raise fields.error(key, f"is more than {MAX_DISTANCE:g} m from the sole; lengths are in m")
    return place


def _polarity(fields: Fields) -> int:
    polarity = fields.integer("polarity", 0)
    if polarity not in (-1, 0, 1):
        raise fields.error("polarity", "must be 1, -1, or 0 where it is not known")
    return polarity


def _nominal_gain(fields: Fields) -> float | None:
    if "nominal_gain" not in fields:
        return None
    gain = fields.number("nominal_gain")
    if gain == 0.0:
        raise fields.error("nominal_gain", "must not be zero; leave it out where it is not known")
    return gain


def _check_names(block: Fields, channels: list[Channel]) -> None:
    if not channels:
        raise block.error("cells", "is missing or empty; add cells, or a six_axis sensor")
    names = [channel.name for channel in channels]
    for name in names:
        if names.count(name) > 1:
            raise block.error("cells", f"'{name}' appears twice; every channel needs its own name")


def _check_cop(block: Fields, channels: list[Channel]) -> None:
    """Refuse channels that give no CoP."""
    if len(channels) < 3:
        raise block.error(
            "cells",
            f"{len(channels)} channels; a CoP needs at least three (fewer give a force alone, "
            "which `shoecal manual` can calibrate)",
        )
    columns = np.array([channel.column for channel in channels])
    # The smaller singular value is how far the cells lie off their common line.
    singular = np.linalg.svd(columns - columns.mean(axis=0), compute_uv=False)
    cells_only = bool(np.all(columns[:, 0] == 1.0))
    if cells_only and singular[1] < MIN_CELL_SPREAD:
        raise block.error("cells", "all cells lie on one line, so no CoP follows; check position_m")
    if np.linalg.matrix_rank(columns, tol=1e-6) < 3:
        raise block.error("cells", "the channels do not fix force and both moments; add channels")


def _holes(block: Fields, cells: FloatArray) -> Holes:
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
