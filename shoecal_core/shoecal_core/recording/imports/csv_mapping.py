"""What the columns of foreign CSV recordings mean: the mapping file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.files import Fields
from shoecal_core.recording.imports.csv_table import CsvColumn, Layout
from shoecal_core.recording.imports.mapping import MappingHead, open_mapping, read_head
from shoecal_core.shoe.shoe import FEET

UNITS_NS = {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}
ALL = "all"
SENSORS = {
    "base_pose": {"translation": 3, "zyx": 3, "quaternion": 4},
    "wrench": {"force": 3, "torque": 3},
    "imu": {"angular_velocity": 3, "linear_acceleration": 3, "quaternion": 4},
}
"""What a table may hold besides joints and cells, and how many columns each quantity takes:
vectors x y z [m], [N], [N m], [rad/s], [m/s^2]; angles z y x [rad], intrinsic Z-Y-X; and
quaternions x y z w."""
_TURNS = ("zyx", "quaternion")


@dataclass(frozen=True)
class NamedColumns:
    """One quantity of the joints, or the readings of cells.

    Attributes:
        named: column by joint or channel.
        every: instead, every column with the name of one of the robot's joints, or the shoe's
            channels.
    """

    named: Mapping[str, CsvColumn]
    every: bool = False

    def __bool__(self) -> bool:
        return self.every or bool(self.named)


@dataclass(frozen=True)
class SensorColumns:
    """One of SENSORS.

    Attributes:
        frame: of its vectors, or in which the base's pose is.
        groups: columns by quantity, of SENSORS those that are there, in that order.
        foot: that a six-axis sensor is on; else empty.
    """

    frame: str
    groups: Mapping[str, tuple[CsvColumn, ...]]
    foot: str


@dataclass(frozen=True)
class TableMapping:
    """What one kind of file holds; empty where it has none of it.

    Attributes:
        time: its time column, scaled to nanoseconds; None: the clock table's.
        joints, efforts: angles [rad] and efforts [N m] of the joints.
        sensors: by their names in SENSORS, in that order.
        cells: readings of channels.
    """

    time: CsvColumn | None
    joints: NamedColumns
    efforts: NamedColumns
    sensors: Mapping[str, SensorColumns]
    cells: NamedColumns


@dataclass(frozen=True)
class CsvMapping:
    """A whole mapping file of tables.

    Attributes:
        head: what every mapping says.
        layout: of the files.
        clock: the table whose time column counts for all, row by row; None: each has its own.
        tables: by name.
    """

    head: MappingHead
    layout: Layout
    clock: str | None
    tables: Mapping[str, TableMapping]


def load_csv_mapping(path: Path, folder: Path) -> CsvMapping:
    """Read a mapping file of tables.

    Args:
        path: of the mapping.
        folder: of the recordings; the mapping may name files there.

    Raises:
        FileError: for anything missing, mistyped or contradictory.
    """
    fields = open_mapping(
        path, "separator", "decimal", "lines_before_header", "lines_after_header", "clock", "tables"
    )
    layout = _layout(fields)
    tables_block = fields.mapping("tables")
    names = dict.fromkeys(tables_block.keys())
    clock = fields.choice("clock", names) if "clock" in fields else None
    tables = {name: _table(tables_block.mapping(name), name, clock) for name in names}
    if not any(table.joints for table in tables.values()):
        raise fields.error("tables", "no table has 'joints'; a run needs them")
    if sum(bool(table.efforts) for table in tables.values()) > 1:
        raise fields.error("tables", "several tables have 'efforts'; keep one of them")
    if not any("wrench" in table.sensors or table.cells for table in tables.values()):
        raise fields.error("tables", "no table has 'cells' or 'wrench'; a run needs readings")
    return CsvMapping(read_head(fields, folder, list(names)), layout, clock, tables)


def _layout(fields: Fields) -> Layout:
    skipped = [
        fields.integer(key, 0, minimum=0) for key in ("lines_before_header", "lines_after_header")
    ]
    separator, decimal = _character(fields, "separator", ","), _character(fields, "decimal", ".")
    if separator == decimal:
        raise fields.error("decimal", "must differ from 'separator'")
    return Layout(separator, decimal, *skipped)


def _table(fields: Fields, name: str, clock: str | None) -> TableMapping:
    fields.only("time", "joints", "efforts", *SENSORS, "cells")
    if clock not in (None, name) and "time" in fields:
        raise fields.error("time", f"is not used, as the times of '{clock}' count; take it out")
    return TableMapping(
        time=_time(fields.mapping("time")) if clock in (None, name) else None,
        joints=_named(fields, "joints"),
        efforts=_named(fields, "efforts"),
        sensors={name: _sensor(fields.mapping(name), name) for name in SENSORS if name in fields},
        cells=_named(fields, "cells"),
    )


def _time(fields: Fields) -> CsvColumn:
    fields.only("column", "unit")
    return CsvColumn(fields.text("column"), UNITS_NS[fields.choice("unit", UNITS_NS)])


def _sensor(fields: Fields, name: str) -> SensorColumns:
    on_foot = ("foot",) if name == "wrench" else ()
    fields.only(*on_foot, "frame", *SENSORS[name])
    if name == "base_pose":
        turns = [key for key in _TURNS if key in fields]
        if len(turns) > 1:
            raise fields.error("zyx", "and 'quaternion' are both there; keep one of them")
        if not turns:
            raise fields.error("zyx", "is missing; add it, or 'quaternion'")
    return SensorColumns(
        fields.text("frame"),
        {
            key: _columns(fields, key, count)
            for key, count in SENSORS[name].items()
            if key in fields or key not in _TURNS
        },
        fields.choice("foot", dict.fromkeys(FEET)) if on_foot else "",
    )


def _named(fields: Fields, key: str) -> NamedColumns:
    """Columns by what they mean."""
    if key not in fields:
        return NamedColumns({})
    if fields.value(key) == ALL:
        return NamedColumns({}, every=True)
    block = fields.mapping(key)
    names = block.keys()
    return NamedColumns({name: _column(block, name, block.value(name)) for name in names})


def _columns(fields: Fields, key: str, count: int) -> tuple[CsvColumn, ...]:
    value = fields.value(key)
    if not isinstance(value, list) or len(value) != count:
        raise fields.error(key, f"expected {'three' if count == 3 else 'four'} columns")
    return tuple(_column(fields, key, item) for item in value)


def _column(fields: Fields, key: str, value: object) -> CsvColumn:
    """A column's name, or its name with a scale (-1 turns an axis round)."""
    if isinstance(value, str):
        return CsvColumn(value)
    if not isinstance(value, dict):
        raise fields.error(key, "expected a column's name, or {column: name, scale: number}")
    item = Fields(fields.path, f"{fields.prefix}.{key}", value)
    item.only("column", "scale")
    scale = item.number("scale")
    if scale == 0.0:
        raise item.error("scale", "must not be zero")
    return CsvColumn(item.text("column"), scale)


def _character(fields: Fields, key: str, default: str) -> str:
    text = fields.text(key, default)
    if len(text) != 1:
        raise fields.error(key, f"expected one character, got {text!r}")
    return text
