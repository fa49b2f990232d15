"""When and where calibrations were put in force: noted by the content of their files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from shoecal_core.files import Fields, read_yaml, write_yaml
from shoecal_ros.common.origin import Origin

FORMAT = 2
"""1: without `origin`."""
LATEST_NS = (2**31 - 1) * 10**9
"""Messages hold no later time."""


@dataclass(frozen=True)
class RecordEntry:
    """When and where a calibration was put in force.

    Attributes:
        since_ns: when [ns].
        robot_hash, shoe_hash: files of robot and shoe that were in use.
        origin: where it was made; None where an older version noted it.
    """

    since_ns: int
    robot_hash: str
    shoe_hash: str
    origin: Origin | None


def read_record(path: Path) -> dict[str, RecordEntry]:
    """Entries by the SHA-256 of their calibration's file.

    Raises:
        FileError: when it is none.
    """
    fields = read_yaml(path)
    fields.format(FORMAT)
    fields.only("format", "calibrations")
    record = {}
    for item in fields.items("calibrations"):
        item.only("file_hash", "since_ns", "robot_hash", "shoe_hash", "origin")
        since_ns = item.integer("since_ns", minimum=0)
        if since_ns > LATEST_NS:
            raise item.error("since_ns", "lies beyond what a stamp holds; delete this file")
        record[item.text("file_hash")] = RecordEntry(
            since_ns, item.text("robot_hash"), item.text("shoe_hash"), _origin(item)
        )
    return record


def _origin(item: Fields) -> Origin | None:
    if "origin" not in item:
        return None
    fields = item.mapping("origin")
    fields.only("simulated", "host", "device")
    return Origin(fields.boolean("simulated"), fields.text("host"), fields.text("device"))


def write_record(path: Path, record: Mapping[str, RecordEntry]) -> None:
    """Write it, atomically; FileError where that fails."""
    write_yaml(
        path,
        {
            "format": FORMAT,
            "calibrations": [
                {
                    "file_hash": digest,
                    "since_ns": entry.since_ns,
                    "robot_hash": entry.robot_hash,
                    "shoe_hash": entry.shoe_hash,
                    "origin": None if entry.origin is None else asdict(entry.origin),
                }
                for digest, entry in record.items()
            ],
        },
    )
