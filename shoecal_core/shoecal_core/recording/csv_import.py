"""Foreign recordings in CSV files, made into a session."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from shoecal_core.errors import FieldError
from shoecal_core.model.urdf import joint_names
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.csv_mapping import (
    CsvMapping,
    PoseColumns,
    TableMapping,
    Trial,
    WrenchColumns,
    load_mapping,
)
from shoecal_core.recording.csv_table import Column, Table
from shoecal_core.recording.session import Session
from shoecal_core.sensing.shoe import AXES, FEET, Shoe, load_shoe

_LATEST_NS = 2**31 * 1_000_000_000
"""Stamps of ROS 2 end there."""


@dataclass(frozen=True)
class _Message:
    stamp_ns: int
    topic: str
    data: bytes


def import_csv(mapping_path: Path, folder: Path, out: Path) -> Session:
    """Make a session of CSV recordings.

    Args:
        mapping_path: says what the columns mean.
        folder: where the recordings are.
        out: the session to make.

    Raises:
        FileError: for the first thing wrong in mapping or recordings, naming file, column and
            line; nothing is made then.
    """
    mapping = load_mapping(Path(mapping_path))
    folder = Path(folder)
    robot, urdf, shoe_path = (_find(mapping, key, folder) for key in ("robot", "urdf", "shoe"))
    importer = _Importer(mapping, folder, joint_names(urdf), load_shoe(shoe_path))
    recorded = [importer.messages(trial) for trial in mapping.trials]
    session = Session.create(out, robot, urdf, shoe_path)
    for trial, run in zip(mapping.trials, recorded, strict=True):
        with session.new_run(trial.motion, trial.support, hint=trial.hint) as writer:
            for message in run:
                writer.write(message.topic, message.data, message.stamp_ns)
    return session


class _Importer:
    def __init__(
        self, mapping: CsvMapping, folder: Path, joints: frozenset[str], shoe: Shoe
    ) -> None:
        self._mapping = mapping
        self._folder = folder
        self._joints = joints
        self._shoe = shoe
        self._check_channels()

    def messages(self, trial: Trial) -> list[_Message]:
        """Messages of one trial, in the order of their stamps."""
        mapping = self._mapping
        tables = {
            name: Table(self._folder / file, mapping.separator, mapping.decimal)
            for name, file in trial.files.items()
        }
        stamps = self._stamps(tables)
        found: list[_Message] = []
        for name, meaning in mapping.tables.items():
            found += self._table(tables[name], meaning, stamps[name])
        return sorted(found, key=attrgetter("stamp_ns"))

    def _stamps(self, tables: dict[str, Table]) -> dict[str, NDArray[np.int64]]:
        """(T,) of each table [ns]."""
        stamps = {}
        for name, meaning in self._mapping.tables.items():
            if meaning.time is not None:
                stamps[name] = _read_stamps(tables[name], meaning.time)
        clock = self._mapping.clock
        if clock is None:
            return stamps
        for table in tables.values():
            if len(table) != len(tables[clock]):
                raise FieldError(
                    table.path,
                    f"has {len(table)} rows, {tables[clock].path.name} has {len(tables[clock])}; "
                    "rows that were sampled together must be as many",
                )
        return dict.fromkeys(tables, stamps[clock])

    def _table(
        self, table: Table, meaning: TableMapping, stamps: NDArray[np.int64]
    ) -> Iterator[_Message]:
        times = stamps.tolist()
        joints = dict(meaning.joints)
        if meaning.all_joints:
            joints = {name: Column(name) for name in table.names if name in self._joints}
            if not joints:
                problem = "no column bears the name of one of the robot's joints"
                raise FieldError(table.path, problem)
        if joints:
            position = table.read_all(tuple(joints.values()))
            for stamp, row in zip(times, position, strict=True):
                data = messages.joint_state(stamp, tuple(joints), row)
                yield _Message(stamp, schemas.JOINT_STATES, data)
        if meaning.base_pose is not None:
            yield from _poses(table, meaning.base_pose, times)
        if meaning.wrench is not None:
            yield from _wrenches(table, meaning.wrench, times)
        if meaning.cells:
            yield from _voltages(table, meaning.cells, times)

    def _check_channels(self) -> None:
        """Refuse joints and channels that robot and shoe do not have."""
        for name, meaning in self._mapping.tables.items():
            for joint in meaning.joints:
                self._check(f"tables.{name}.joints", joint, sorted(self._joints))
            for cell in meaning.cells:
                self._check(f"tables.{name}.cells", cell, self._shoe.names)
            if meaning.wrench is not None:
                foot = meaning.wrench.foot
                if not any(f"{foot}/{axis}" in self._shoe.names for axis in AXES):
                    raise FieldError(
                        self._mapping.path,
                        f"'{self._shoe.name}' has no six-axis sensor on the {foot} foot",
                        field=f"tables.{name}.wrench",
                    )

    def _check(self, field: str, name: str, known: list[str] | tuple[str, ...]) -> None:
        if name not in known:
            raise FieldError(
                self._mapping.path, f"'{name}' is not one of: {', '.join(known)}", field=field
            )


def _read_stamps(table: Table, time: Column) -> NDArray[np.int64]:
    nanoseconds = table.read(time)
    outside = (nanoseconds < 0.0) | (nanoseconds >= _LATEST_NS)
    if outside.any():
        place = int(np.flatnonzero(outside)[0])
        raise table.error(
            time.name, place, "time is negative or after 2038; shift it, check its unit"
        )
    stamps = np.rint(nanoseconds).astype(np.int64)
    back = np.flatnonzero(np.diff(stamps) <= 0)
    if len(back):
        raise table.error(time.name, int(back[0]) + 1, "time repeats or goes back; sort the rows")
    return stamps


def _poses(table: Table, columns: PoseColumns, times: list[int]) -> Iterator[_Message]:
    translation = table.read_all(columns.translation)
    quaternions = Rotation.from_euler("ZYX", table.read_all(columns.zyx)).as_quat()
    for stamp, position, quaternion in zip(times, translation, quaternions, strict=True):
        data = messages.pose(stamp, columns.frame, position, quaternion)
        yield _Message(stamp, schemas.BASE_POSE, data)


def _wrenches(table: Table, columns: WrenchColumns, times: list[int]) -> Iterator[_Message]:
    topic = schemas.FORCE_TORQUE[FEET.index(columns.foot)]
    forces, torques = table.read_all(columns.force), table.read_all(columns.torque)
    for stamp, force, torque in zip(times, forces, torques, strict=True):
        yield _Message(stamp, topic, messages.wrench(stamp, columns.frame, force, torque))


def _voltages(table: Table, cells: Mapping[str, Column], times: list[int]) -> Iterator[_Message]:
    values = table.read_all(tuple(cells.values()))
    good = np.full(len(cells), schemas.GOOD)
    for sequence, (stamp, row) in enumerate(zip(times, values, strict=True)):
        data = messages.shoe_voltages(stamp, sequence, tuple(cells), row, good)
        yield _Message(stamp, schemas.VOLTAGES, data)


def _find(mapping: CsvMapping, key: str, folder: Path) -> Path:
    """A file that the mapping names: beside the mapping, else in the recordings' folder."""
    name = str(getattr(mapping, key))
    for place in (mapping.path.parent / name, folder / name):
        if place.is_file():
            return place
    raise FieldError(
        mapping.path, f"'{name}' is neither beside this file nor in {folder}", field=key
    )
