"""What every mapping file says: files, trials, the unit of angles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import date, datetime
from pathlib import Path

import numpy as np

from shoecal_core.files import Fields, read_yaml
from shoecal_core.recording.info import HANGING
from shoecal_core.recording.listing import HINTS, read_support
from shoecal_core.robot.double_support import DoubleSupport

FORMAT = 1
ANGLE_UNIT, BAG = "angle_unit", "bag"
_ANGLE_UNITS = {"rad": 1.0, "deg": float(np.pi / 180.0)}


@dataclass(frozen=True)
class Trial:
    """One run to import.

    Attributes:
        motion: its name.
        support: pose of the right sole in the left; None where there is none, as in walking.
        hint: `train`, `test` or empty.
        files: relative to the recordings' folder, by table; of a bag one, by BAG.
        start_ns: when it began; its time columns count from there [ns].
        from_s, to_s: span since its first row or message [s]; None: from the start, to the end.
    """

    motion: str
    support: DoubleSupport | None
    hint: str
    files: Mapping[str, str]
    start_ns: int
    from_s: float | None
    to_s: float | None


@dataclass(frozen=True)
class MappingHead:
    """What every mapping file says.

    Attributes:
        path: the file.
        robot, urdf, shoe: files that it names.
        angle_unit: joint angles and `zyx` take it to be rad.
        trials: to import, in its order.
    """

    path: Path
    robot: Path
    urdf: Path
    shoe: Path
    angle_unit: float
    trials: tuple[Trial, ...]

    def recordings(self, folder: Path) -> set[Path]:
        """Files that the trials name, in the recordings' folder."""
        return {folder / file for trial in self.trials for file in trial.files.values()}


def open_mapping(path: Path, *own: str) -> Fields:
    """A mapping file, which may have keys of its own besides those that every mapping has.

    Raises:
        FileError: it cannot be read, is of another format or kind, or has unknown keys.
    """
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only("format", "robot", "urdf", "shoe", *own, "trials", ANGLE_UNIT)
    return fields


def read_head(fields: Fields, folder: Path, tables: Sequence[str] | None) -> MappingHead:
    """What every mapping says.

    Args:
        fields: of the mapping.
        folder: of the recordings; a file is looked for next to the mapping first, then here.
        tables: of the mapping; None: it is one of bags.

    Raises:
        FieldError: for anything missing or wrong, and for a file that is in neither place.
    """
    found = []
    for key in ("robot", "urdf", "shoe"):
        name = fields.text(key)
        places = [place / name for place in (fields.path.parent, folder)]
        if not any(place.is_file() for place in places):
            raise fields.error(key, f"'{name}' is neither next to this file nor in {folder}")
        found.append(next(place for place in places if place.is_file()))
    unit = fields.choice(ANGLE_UNIT, _ANGLE_UNITS) if ANGLE_UNIT in fields else "rad"
    trials = tuple(_trial(item, tables) for item in fields.items("trials"))
    robot, urdf, shoe = found
    return MappingHead(fields.path, robot, urdf, shoe, _ANGLE_UNITS[unit], trials)


def _trial(fields: Fields, tables: Sequence[str] | None) -> Trial:
    own = (BAG,) if tables is None else ("start", "files")
    fields.only("motion", "support", "set", "from_s", "to_s", *own)
    files = fields
    if tables is not None:
        files = fields.mapping("files")
        files.only(*tables)
    motion, support = fields.text("motion"), read_support(fields)
    if motion == HANGING and support is not None:
        raise fields.error("support", "a robot that hangs stands nowhere; leave it out")
    from_s = fields.number("from_s", minimum=0.0) if "from_s" in fields else None
    return Trial(
        motion=motion,
        support=support,
        hint=fields.choice("set", dict.fromkeys(HINTS)) if "set" in fields else "",
        files={name: files.text(name) for name in (tables or (BAG,))},
        start_ns=_start(fields) if "start" in fields else 0,
        from_s=from_s,
        to_s=fields.number("to_s", above=from_s or 0.0) if "to_s" in fields else None,
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
