"""What the columns of foreign CSV recordings mean: the mapping file."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import date, datetime
from pathlib import Path

from shoecal_core.files import Fields, read_yaml
from shoecal_core.recording.csv_table import CsvColumn, Layout
from shoecal_core.recording.foreign import (
    ANGLE_UNIT,
    RUN_KEYS,
    SPAN_KEYS,
    MappedFiles,
    RunToImport,
    mapped_files,
    read_angle_unit,
    read_run_to_import,
    read_span,
)
from shoecal_core.shoe.shoe import FEET

FORMAT = 1
UNITS_NS = {"s": 1_000_000_000, "ms": 1_000_000, "us": 1_000, "ns": 1}
ALL_JOINTS = "all"


@dataclass(frozen=True)
class JointColumns:
    """One quantity of the joints.

    Attributes:
        named: column by joint.
        every: instead, every column with the name of one of the robot's joints.
    """

    named: Mapping[str, CsvColumn]
    every: bool = False

    def __bool__(self) -> bool:
        return self.every or bool(self.named)


@dataclass(frozen=True)
class PoseColumns:
    """The floating base: translation x y z [m], and one of two rotations.

    Attributes:
        zyx: angles z y x [rad], intrinsic Z-Y-X; None where `quaternion` is there.
        quaternion: x y z w; None where `zyx` is there.
    """

    frame: str
    translation: tuple[CsvColumn, ...]
    zyx: tuple[CsvColumn, ...] | None
    quaternion: tuple[CsvColumn, ...] | None


@dataclass(frozen=True)
class WrenchColumns:
    """A six-axis sensor: force x y z [N], torque x y z [N m]."""

    foot: str
    frame: str
    force: tuple[CsvColumn, ...]
    torque: tuple[CsvColumn, ...]


@dataclass(frozen=True)
class ImuColumns:
    """An IMU: rates [rad/s], accelerations [m/s^2], orientation x y z w where it has one."""

    frame: str
    angular_velocity: tuple[CsvColumn, ...]
    linear_acceleration: tuple[CsvColumn, ...]
    quaternion: tuple[CsvColumn, ...] | None


@dataclass(frozen=True)
class TableMapping:
    """What one kind of file holds; empty or None where it has none of it.

    Attributes:
        time: its time column, scaled to nanoseconds; None: the clock table's.
        joints, efforts: angles [rad] and efforts [N m] of the joints.
        cells: column by channel.
    """

    time: CsvColumn | None
    joints: JointColumns
    efforts: JointColumns
    base_pose: PoseColumns | None
    wrench: WrenchColumns | None
    imu: ImuColumns | None
    cells: Mapping[str, CsvColumn]


@dataclass(frozen=True)
class Trial:
    """One run to import.

    Attributes:
        run: how it is listed.
        start_ns: when it began; its time columns count from there [ns].
        files: by table, relative to the recordings' folder.
        from_s, to_s: span since the first row of its files [s]; None: from the start, to the end.
    """

    run: RunToImport
    start_ns: int
    files: Mapping[str, str]
    from_s: float | None
    to_s: float | None


@dataclass(frozen=True)
class CsvMapping:
    """A whole mapping file.

    Attributes:
        path: the file.
        files: robot, URDF and shoe.
        angle_unit: joint angles and `zyx` take it to be rad.
        clock: the table whose time column counts for all, row by row; None: each has its own.
    """

    path: Path
    files: MappedFiles
    layout: Layout
    angle_unit: float
    clock: str | None
    tables: Mapping[str, TableMapping]
    trials: tuple[Trial, ...]


def load_mapping(path: Path, folder: Path) -> CsvMapping:
    """Read a mapping file.

    Args:
        path: of the mapping.
        folder: of the recordings; the mapping may name files there.

    Raises:
        FileError: for anything missing, mistyped or contradictory.
    """
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only(
        "format", "robot", "urdf", "shoe", "separator", "decimal", "lines_before_header",
        "lines_after_header", "clock", "tables", "trials", ANGLE_UNIT,
    )  # fmt: skip
    layout = _layout(fields)
    tables_block = fields.mapping("tables")
    names = dict.fromkeys(tables_block.keys())
    clock = fields.choice("clock", names) if "clock" in fields else None
    tables = {name: _table(tables_block.mapping(name), name, clock) for name in names}
    if not any(table.joints for table in tables.values()):
        raise fields.error("tables", "no table has 'joints'; a run needs them")
    if sum(bool(table.efforts) for table in tables.values()) > 1:
        raise fields.error("tables", "several tables have 'efforts'; keep one of them")
    if not any(table.wrench or table.cells for table in tables.values()):
        raise fields.error("tables", "no table has 'cells' or 'wrench'; a run needs readings")
    return CsvMapping(
        path=Path(path),
        files=mapped_files(fields, folder),
        layout=layout,
        angle_unit=read_angle_unit(fields),
        clock=clock,
        tables=tables,
        trials=tuple(_trial(item, tuple(names)) for item in fields.items("trials")),
    )


def _layout(fields: Fields) -> Layout:
    skipped = [
        fields.integer(key, 0, minimum=0) for key in ("lines_before_header", "lines_after_header")
    ]
    separator, decimal = _character(fields, "separator", ","), _character(fields, "decimal", ".")
    if separator == decimal:
        raise fields.error("decimal", "must differ from 'separator'")
    return Layout(separator, decimal, *skipped)


def _table(fields: Fields, name: str, clock: str | None) -> TableMapping:
    fields.only("time", "joints", "efforts", "base_pose", "wrench", "imu", "cells")
    if clock not in (None, name) and "time" in fields:
        raise fields.error("time", f"is not used, as the times of '{clock}' count; take it out")
    return TableMapping(
        time=_time(fields.mapping("time")) if clock in (None, name) else None,
        joints=_joints(fields, "joints"),
        efforts=_joints(fields, "efforts"),
        base_pose=_pose(fields.mapping("base_pose")) if "base_pose" in fields else None,
        wrench=_wrench(fields.mapping("wrench")) if "wrench" in fields else None,
        imu=_imu(fields.mapping("imu")) if "imu" in fields else None,
        cells=_named(fields, "cells"),
    )


def _time(fields: Fields) -> CsvColumn:
    fields.only("column", "unit")
    return CsvColumn(fields.text("column"), UNITS_NS[fields.choice("unit", UNITS_NS)])


def _joints(fields: Fields, key: str) -> JointColumns:
    if key in fields and fields.value(key) == ALL_JOINTS:
        return JointColumns({}, every=True)
    return JointColumns(_named(fields, key))


def _pose(fields: Fields) -> PoseColumns:
    fields.only("frame", "translation", "zyx", "quaternion")
    if "zyx" in fields and "quaternion" in fields:
        raise fields.error("zyx", "and 'quaternion' are both there; keep one of them")
    if "zyx" not in fields and "quaternion" not in fields:
        raise fields.error("zyx", "is missing; add it, or 'quaternion'")
    return PoseColumns(
        fields.text("frame"),
        _columns(fields, "translation", 3),
        zyx=_columns(fields, "zyx", 3) if "zyx" in fields else None,
        quaternion=_columns(fields, "quaternion", 4) if "quaternion" in fields else None,
    )


def _wrench(fields: Fields) -> WrenchColumns:
    fields.only("foot", "frame", "force", "torque")
    return WrenchColumns(
        foot=fields.choice("foot", dict.fromkeys(FEET)),
        frame=fields.text("frame"),
        force=_columns(fields, "force", 3),
        torque=_columns(fields, "torque", 3),
    )


def _imu(fields: Fields) -> ImuColumns:
    fields.only("frame", "angular_velocity", "linear_acceleration", "quaternion")
    return ImuColumns(
        frame=fields.text("frame"),
        angular_velocity=_columns(fields, "angular_velocity", 3),
        linear_acceleration=_columns(fields, "linear_acceleration", 3),
        quaternion=_columns(fields, "quaternion", 4) if "quaternion" in fields else None,
    )


def _named(fields: Fields, key: str) -> dict[str, CsvColumn]:
    """Columns by what they mean."""
    if key not in fields:
        return {}
    block = fields.mapping(key)
    names = block.keys()
    return {name: _column(block, name, block.value(name)) for name in names}


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


def _trial(fields: Fields, tables: tuple[str, ...]) -> Trial:
    fields.only(*RUN_KEYS, *SPAN_KEYS, "start", "files")
    files = fields.mapping("files")
    files.only(*tables)
    from_s, to_s = read_span(fields)
    return Trial(
        run=read_run_to_import(fields),
        start_ns=_start(fields) if "start" in fields else 0,
        files={name: files.text(name) for name in tables},
        from_s=from_s,
        to_s=to_s,
    )


def _start(fields: Fields) -> int:
    """When a trial began [ns since 1970]: seconds, or a date with time and zone."""
    value = fields.value("start")
    if not isinstance(value, str | date):
        return round(fields.number("start", minimum=0.0) * 1e9)
    moment: datetime | None = None
    with suppress(ValueError):
        moment = datetime.fromisoformat(str(value))
    if moment is None or moment.tzinfo is None:
        raise fields.error(
            "start", "expected seconds, or a time with its zone such as 2026-03-01T10:15:00+01:00"
        )
    return round(moment.timestamp() * 1e9)


def _character(fields: Fields, key: str, default: str) -> str:
    text = fields.text(key, default)
    if len(text) != 1:
        raise fields.error(key, f"expected one character, got {text!r}")
    return text
