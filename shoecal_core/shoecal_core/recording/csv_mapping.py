"""What the columns of foreign CSV recordings mean: the mapping file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.files import Fields, read_yaml
from shoecal_core.model.double_support import DoubleSupport, read_support
from shoecal_core.recording.csv_table import Column
from shoecal_core.recording.listing import HINTS
from shoecal_core.sensing.shoe import FEET

FORMAT = 1
UNITS_NS = {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}
ALL_JOINTS = "all"


@dataclass(frozen=True)
class PoseColumns:
    """The floating base: translation x y z [m], angles z y x [rad], intrinsic Z-Y-X."""

    frame: str
    translation: tuple[Column, ...]
    zyx: tuple[Column, ...]


@dataclass(frozen=True)
class WrenchColumns:
    """A six-axis sensor: force x y z [N], torque x y z [N m]."""

    foot: str
    frame: str
    force: tuple[Column, ...]
    torque: tuple[Column, ...]


@dataclass(frozen=True)
class TableMapping:
    """What one kind of file holds.

    Attributes:
        time: its time column, scaled to nanoseconds; None: the clock table's.
        joints: column by joint; None: none here.
        all_joints: every column that bears the name of one of the robot's joints.
        cells: column by channel.
    """

    time: Column | None
    joints: Mapping[str, Column]
    all_joints: bool
    base_pose: PoseColumns | None
    wrench: WrenchColumns | None
    cells: Mapping[str, Column]


@dataclass(frozen=True)
class Trial:
    """One run to import: its files by table, relative to the recordings' folder."""

    motion: str
    support: DoubleSupport | None
    hint: str
    files: Mapping[str, str]


@dataclass(frozen=True)
class CsvMapping:
    """A whole mapping file.

    Attributes:
        path: the file.
        robot, urdf, shoe: as named there.
        clock: the table whose time column counts for all, row by row; None: each has its own.
    """

    path: Path
    robot: str
    urdf: str
    shoe: str
    separator: str
    decimal: str
    clock: str | None
    tables: Mapping[str, TableMapping]
    trials: tuple[Trial, ...]


def load_mapping(path: Path) -> CsvMapping:
    """Read a mapping file.

    Raises:
        FileError: for anything missing, mistyped or contradictory.
    """
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only(
        "format", "robot", "urdf", "shoe", "separator", "decimal", "clock", "tables", "trials"
    )
    separator, decimal = _character(fields, "separator", ","), _character(fields, "decimal", ".")
    if separator == decimal:
        raise fields.error("decimal", "must differ from 'separator'")
    tables_block = fields.mapping("tables")
    names = dict.fromkeys(tables_block.keys())
    clock = fields.choice("clock", names) if "clock" in fields else None
    tables = {name: _table(tables_block.mapping(name), name, clock) for name in names}
    if not any(table.joints or table.all_joints for table in tables.values()):
        raise fields.error("tables", "no table gives 'joints'; a run needs them")
    if not any(table.wrench or table.cells for table in tables.values()):
        raise fields.error("tables", "no table gives 'cells' or 'wrench'; a run needs readings")
    return CsvMapping(
        path=Path(path),
        robot=fields.text("robot"),
        urdf=fields.text("urdf"),
        shoe=fields.text("shoe"),
        separator=separator,
        decimal=decimal,
        clock=clock,
        tables=tables,
        trials=tuple(_trial(item, tuple(names)) for item in fields.items("trials")),
    )


def _table(fields: Fields, name: str, clock: str | None) -> TableMapping:
    fields.only("time", "joints", "base_pose", "wrench", "cells")
    if clock not in (None, name) and "time" in fields:
        raise fields.error("time", f"is not used, as the times of '{clock}' count; take it out")
    all_joints = "joints" in fields and fields.value("joints") == ALL_JOINTS
    return TableMapping(
        time=_time(fields.mapping("time")) if clock in (None, name) else None,
        joints={} if all_joints else _named(fields, "joints"),
        all_joints=all_joints,
        base_pose=_pose(fields.mapping("base_pose")) if "base_pose" in fields else None,
        wrench=_wrench(fields.mapping("wrench")) if "wrench" in fields else None,
        cells=_named(fields, "cells"),
    )


def _time(fields: Fields) -> Column:
    fields.only("column", "unit")
    return Column(fields.text("column"), UNITS_NS[fields.choice("unit", UNITS_NS)])


def _pose(fields: Fields) -> PoseColumns:
    fields.only("frame", "translation", "zyx")
    return PoseColumns(fields.text("frame"), _three(fields, "translation"), _three(fields, "zyx"))


def _wrench(fields: Fields) -> WrenchColumns:
    fields.only("foot", "frame", "force", "torque")
    return WrenchColumns(
        foot=fields.choice("foot", dict.fromkeys(FEET)),
        frame=fields.text("frame"),
        force=_three(fields, "force"),
        torque=_three(fields, "torque"),
    )


def _named(fields: Fields, key: str) -> dict[str, Column]:
    """Columns by what they mean."""
    if key not in fields:
        return {}
    block = fields.mapping(key)
    names = block.keys()
    return {name: _column(block, name, block.value(name)) for name in names}


def _three(fields: Fields, key: str) -> tuple[Column, ...]:
    value = fields.value(key)
    if not isinstance(value, list) or len(value) != 3:
        raise fields.error(key, "expected three columns")
    return tuple(_column(fields, key, item) for item in value)


def _column(fields: Fields, key: str, value: object) -> Column:
    """A column's name, or its name with a scale (-1 turns an axis round)."""
    if isinstance(value, str):
        return Column(value)
    if not isinstance(value, dict):
        raise fields.error(key, "expected a column's name, or {column: name, scale: number}")
    item = Fields(fields.path, f"{fields.prefix}.{key}", value)
    item.only("column", "scale")
    scale = item.number("scale")
    if scale == 0.0:
        raise item.error("scale", "must not be zero")
    return Column(item.text("column"), scale)


def _trial(fields: Fields, tables: tuple[str, ...]) -> Trial:
    fields.only("motion", "support", "set", "files")
    files = fields.mapping("files")
    files.only(*tables)
    return Trial(
        motion=fields.text("motion"),
        support=read_support(fields),
        hint=fields.choice("set", dict.fromkeys(HINTS)) if "set" in fields else "",
        files={name: files.text(name) for name in tables},
    )


def _character(fields: Fields, key: str, default: str) -> str:
    text = fields.text(key, default)
    if len(text) != 1:
        raise fields.error(key, f"expected one character, got {text!r}")
    return text
