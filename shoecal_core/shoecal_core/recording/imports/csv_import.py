"""Foreign recordings in CSV files, made into a session."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import FieldError, named_together
from shoecal_core.recording import messages
from shoecal_core.recording.imports import foreign
from shoecal_core.recording.imports.csv_mapping import (
    CsvMapping,
    NamedColumns,
    SensorColumns,
    load_csv_mapping,
)
from shoecal_core.recording.imports.csv_table import CsvColumn, CsvTable
from shoecal_core.recording.imports.csv_times import no_common_time, timed
from shoecal_core.recording.imports.foreign import ImportedRun, StampedMessage, Stamps
from shoecal_core.recording.imports.imported_angles import (
    check_angles,
    no_angles,
    optional_joints,
)
from shoecal_core.recording.imports.mapping import Trial
from shoecal_core.recording.packets import ANGLES_S, READINGS_S, find_packets
from shoecal_core.recording.session import Session
from shoecal_core.robot.urdf import Outline, read_outline
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe

MAX_ODD_ROWS = 5
MAX_ODD_ROWS_SHARE = 0.02
"""Tables of one trial whose numbers of rows differ by more are not row by row of one clock."""


def import_csv(mapping_path: Path, folder: Path, out: Path) -> Session:
    """Make a session of CSV recordings.

    Args:
        mapping_path: says what the columns mean.
        folder: where the recordings are.
        out: the session to make.

    Returns:
        The session. What was left out of a run is in the run's `info.notes`.

    Raises:
        FileError: for the first thing wrong in mapping or recordings, naming file, column and
            line; nothing is made then.
    """
    folder = Path(folder)
    mapping = load_csv_mapping(Path(mapping_path), folder)
    head = mapping.head
    importer = _Importer(mapping, folder, read_outline(head.urdf), load_shoe(head.shoe))
    with named_together(head.recordings(folder)):
        runs = [importer.run(trial) for trial in head.trials]
    return foreign.write_session(out, head, check_angles(head, runs))


@dataclass
class _Rows:
    """The rows of one file that count.

    Attributes:
        stamps: (T,) [ns].
        kept: (T,) their places in the file.
        notes: of the trial, to which what is changed or left out is added.
    """

    table: CsvTable
    stamps: Stamps
    kept: IntArray
    notes: list[str]

    def read(self, columns: tuple[CsvColumn, ...]) -> FloatArray:
        """(T, c) numbers, NaN for those that are not there; how many these are is noted."""
        return self._noted(columns, self.table.read_all(columns)[self.kept])

    def read_some(self, columns: tuple[CsvColumn, ...]) -> tuple[Stamps, FloatArray]:
        """Stamps (k,) of the rows that have any value, and their (k, c) numbers; else of all.

        What is logged faster than it is sampled, or in one table with something else, has rows
        between its own; how many is noted.
        """
        found = self.table.read_all(columns)[self.kept]
        some = ~np.isnan(found).all(axis=1)
        if some.all() or not some.any():
            return self.stamps, self._noted(columns, found)
        more = f" and {len(columns) - 1} more" if columns[1:] else ""
        self.notes.append(
            f"{self.table.path.name}: {int((~some).sum())} of {len(found)} rows have no value of "
            f"'{columns[0].name}'{more}, and are left out of them"
        )
        return self.stamps[some], self._noted(columns, found[some])

    def _noted(self, columns: tuple[CsvColumn, ...], found: FloatArray) -> FloatArray:
        """Numbers (T, c) as they are; how many are not there is noted."""
        missing = np.isnan(found).sum(axis=0)
        if missing.any():
            worst = columns[int(np.argmax(missing))].name
            self.notes.append(
                f"{self.table.path.name}: {int(missing.sum())} values are not there, "
                f"{int(missing.max())} of {len(found)} of '{worst}'"
            )
        return found

    def read_whole(self, columns: tuple[CsvColumn, ...]) -> tuple[Stamps, FloatArray]:
        """Stamps (k,) of the rows that have all values, and their (k, c) numbers.

        Raises:
            FieldError: where no row has all.
        """
        found = self.read(columns)
        whole = np.isfinite(found).all(axis=1)
        if not whole.any():
            names = ", ".join(column.name for column in columns)
            raise FieldError(
                self.table.path,
                f"no row has a number in each of {names}; record them, or take them out of the "
                "mapping",
            )
        return self.stamps[whole], found[whole]


class _Importer:
    def __init__(self, mapping: CsvMapping, folder: Path, urdf: Outline, shoe: Shoe) -> None:
        self._mapping = mapping
        self._folder = folder
        self._joints = urdf.joints
        self._optional = optional_joints(mapping.head.robot)
        self._shoe = shoe
        self._check_channels()

    def run(self, trial: Trial) -> ImportedRun:
        """One trial."""
        mapping, notes = self._mapping, list[str]()
        tables = {
            name: CsvTable(self._folder / file, mapping.layout)
            for name, file in trial.files.items()
        }
        rows = _cut(self._rows(tables, trial.start_ns, notes), trial)
        self._check_packets(rows)
        found = self._joint_states(rows)
        for name, meaning in mapping.tables.items():
            here = rows[name]
            for sensor, columns in meaning.sensors.items():
                found += self._sensor(sensor, here, columns)
            if meaning.cells:
                cells = self._columns(here.table, meaning.cells, "cells", self._shoe.names)
                stamps, values = here.read_some(tuple(cells.values()))
                found += foreign.voltages(stamps, tuple(cells), values)
        source = next(tables[name].path for name, one in mapping.tables.items() if one.joints)
        return ImportedRun(source, trial, found, tuple(notes))

    def _rows(
        self, tables: Mapping[str, CsvTable], start_ns: int, notes: list[str]
    ) -> dict[str, _Rows]:
        """Rows that count of each table, with their stamps."""
        clock = self._mapping.clock
        if clock is None:
            found = {}
            for name, meaning in self._mapping.tables.items():
                assert meaning.time is not None
                stamps, kept = timed(tables[name], meaning.time, start_ns, notes)
                found[name] = _Rows(tables[name], stamps, kept, notes)
            self._check_common_time(found)
            return found
        count = self._common_rows(tables, clock, notes)
        time = self._mapping.tables[clock].time
        assert time is not None
        stamps, kept = timed(tables[clock], time, start_ns, notes, count)
        return {name: _Rows(table, stamps, kept, notes) for name, table in tables.items()}

    def _check_common_time(self, rows: Mapping[str, _Rows]) -> None:
        """Refuse tables, each with its own times, that have no time in common with the joints'."""
        tables = self._mapping.tables
        joints = next(name for name, meaning in tables.items() if meaning.joints)
        time, here = tables[joints].time, rows[joints]
        assert time is not None
        for name, other in rows.items():
            if name == joints:
                continue
            own, others = ((one.table.path.name, one.stamps) for one in (here, other))
            if problem := no_common_time(own, others):
                raise FieldError(here.table.path, problem, field=f"column '{time.name}'")

    def _check_packets(self, rows: Mapping[str, _Rows]) -> None:
        """Refuse tables of joints or readings that are stamped packet by packet."""
        for name, meaning in self._mapping.tables.items():
            time = self._mapping.tables[self._mapping.clock or name].time
            if time is None or not (meaning.joints or meaning.cells or "wrench" in meaning.sensors):
                continue
            what, bearable = (
                ("joint angles", ANGLES_S) if meaning.joints else ("readings", READINGS_S)
            )
            here = rows[name]
            since = 1e-9 * (here.stamps - here.stamps[0])
            if (packets := find_packets(since, bearable)) is not None:
                place = int(here.kept[packets.first])
                raise here.table.error(time.name, place, packets.describe(what))

    def _common_rows(self, tables: Mapping[str, CsvTable], clock: str, notes: list[str]) -> int:
        """Number of rows that all tables of one clock have."""
        count = min(map(len, tables.values()))
        for table in tables.values():
            more = len(table) - count
            if more > max(MAX_ODD_ROWS, MAX_ODD_ROWS_SHARE * count):
                raise FieldError(
                    table.path,
                    f"has {len(table)} rows, another file of its trial {count}; rows of one clock "
                    f"must be as many: give each table its own 'time' instead of 'clock: {clock}'",
                )
            if more:
                ends = f"the last {more} rows are" if more > 1 else "the last row is"
                notes.append(
                    f"{table.path.name}: {ends} left out, another file has only {count} rows"
                )
        return count

    def _joint_states(self, rows: Mapping[str, _Rows]) -> list[StampedMessage]:
        """Angles, with the efforts at the same instants."""
        efforts: dict[str, FloatArray] = {}
        for name, meaning in self._mapping.tables.items():
            if meaning.efforts:
                measured = rows[name]
                columns = self._columns(measured.table, meaning.efforts, "efforts", self._joints)
                read = measured.read(tuple(columns.values()))
                efforts = dict(zip(columns, read.T, strict=True))
        found: list[StampedMessage] = []
        for name, meaning in self._mapping.tables.items():
            if not meaning.joints:
                continue
            here = rows[name]
            columns = self._columns(here.table, meaning.joints, "joints", self._joints)
            stamps, position = here.read_some(tuple(columns.values()))
            effort = None
            if efforts:
                effort = np.full((len(stamps), len(columns)), np.nan)
                for place, joint in enumerate(columns):
                    if joint in efforts:
                        effort[:, place] = np.interp(stamps, measured.stamps, efforts[joint])
            position = position * self._mapping.head.angle_unit
            for (joint, column), angles in zip(columns.items(), position.T, strict=True):
                if joint not in self._optional and np.isnan(angles).all():
                    where = f"column '{column.name}'"
                    raise no_angles(here.table.path, joint, self._mapping.head.robot, where)
            found += foreign.joint_states(stamps, tuple(columns), position, effort)
        return found

    def _sensor(self, sensor: str, rows: _Rows, columns: SensorColumns) -> list[StampedMessage]:
        """One of SENSORS."""
        stamps, values = rows.read_whole(tuple(chain.from_iterable(columns.groups.values())))
        if sensor == "wrench":
            return foreign.wrenches(columns.foot, stamps, columns.frame, values)
        if sensor == "imu":
            return foreign.imu(stamps, columns.frame, values)
        if "zyx" in columns.groups:
            turns = Rotation.from_euler("ZYX", self._mapping.head.angle_unit * values[:, 3:])
            values = np.hstack([values[:, :3], turns.as_quat()])
        good = foreign.whole_poses(rows.table.path, sensor, values, rows.notes)
        return foreign.base_poses(stamps[good], columns.frame, values[good])

    @staticmethod
    def _columns(
        table: CsvTable, wanted: NamedColumns, key: str, known: Collection[str]
    ) -> Mapping[str, CsvColumn]:
        """Columns by joint or channel."""
        if not wanted.every:
            return wanted.named
        found = {name: CsvColumn(name) for name in table.names if name in known}
        if not found:
            whose = "the shoe's channels" if key == "cells" else "the robot's joints"
            problem = f"no column has the name of one of {whose} ({', '.join(sorted(known))})"
            raise FieldError(table.path, f"{problem}; name its columns in '{key}'")
        return found

    def _check_channels(self) -> None:
        """Refuse joints and channels that robot and shoe do not have."""
        for name, meaning in self._mapping.tables.items():
            for key, columns in (("joints", meaning.joints), ("efforts", meaning.efforts)):
                for joint in columns.named:
                    self._check(f"tables.{name}.{key}", joint, sorted(self._joints))
            for cell in meaning.cells.named:
                self._check(f"tables.{name}.cells", cell, self._shoe.names)
            if (wrench := meaning.sensors.get("wrench")) is not None:
                foreign.check_six_axis(
                    self._mapping.head.path, f"tables.{name}.wrench", self._shoe, wrench.foot
                )

    def _check(self, field: str, name: str, known: list[str] | tuple[str, ...]) -> None:
        if name not in known:
            raise FieldError(
                self._mapping.head.path, f"'{name}' is not one of: {', '.join(known)}", field=field
            )


def _cut(rows: dict[str, _Rows], trial: Trial) -> dict[str, _Rows]:
    """The rows of a trial's span, which counts from the first row of all its tables.

    Raises:
        FieldError: for a table that has no row there.
    """
    if trial.from_s is None and trial.to_s is None:
        return rows
    start = min(int(one.stamps[0]) for one in rows.values())
    from_s, to_s = trial.from_s or 0.0, math.inf if trial.to_s is None else trial.to_s
    until = "" if trial.to_s is None else f" to {trial.to_s:g} s"
    cut = {}
    for name, one in rows.items():
        since = (one.stamps - start) / messages.SECOND_NS
        inside = (since >= from_s) & (since <= to_s)
        if not inside.any():
            raise FieldError(
                one.table.path,
                f"has no row from {from_s:g} s{until}: its rows are at {since[0]:.3f} to "
                f"{since[-1]:.3f} s, counted from the first row of the trial's files; correct "
                "'from_s' and 'to_s' of the mapping",
            )
        cut[name] = replace(one, stamps=one.stamps[inside], kept=one.kept[inside])
    return cut
