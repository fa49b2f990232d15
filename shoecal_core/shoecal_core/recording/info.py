"""What a run file says of itself: the MCAP metadata record `shoecal`."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.errors import ShoecalError, VersionError
from shoecal_core.recording.errors import DamagedError, RecordingError
from shoecal_core.robot.double_support import DoubleSupport

FORMAT = 1
RECORD = "shoecal"
"""Name of the metadata record."""

HANGING = "hanging"
"""Motion of a robot that hangs with both feet in the air, to show the zeros of its sensors."""

_CHECKSUM = "checksum"


@dataclass(frozen=True)
class RunInfo:
    """One run's place in its session and what it was recorded with.

    Attributes:
        run: number, from 1.
        motion: name of the motion.
        support: pose of the right sole in the left; None where there is none, as in walking.
        robot, shoe: names.
        robot_hash, shoe_hash, urdf_hash: SHA-256 of robot.yaml, shoe.yaml and robot.urdf.
        notes: what an import changed or left out, a line each, for a person to read.
    """

    run: int
    motion: str
    support: DoubleSupport | None
    robot: str
    shoe: str
    robot_hash: str
    shoe_hash: str
    urdf_hash: str
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.run < 1:
            raise ShoecalError(f"run {self.run}: runs are numbered from 1")

    @property
    def hanging(self) -> bool:
        """Whether both feet are in the air all the time."""
        return self.motion == HANGING and self.support is None

    def to_metadata(self) -> dict[str, str]:
        """Fields of the record, with a checksum: no other one covers it in a cut file."""
        support = self.support
        place = (support.dx, support.dy, support.dtheta) if support else ()
        fields = {
            "format_version": str(FORMAT),
            "run": str(self.run),
            "motion": self.motion,
            "support": " ".join(repr(float(value)) for value in place),
            "robot": self.robot,
            "shoe": self.shoe,
            "robot_hash": self.robot_hash,
            "shoe_hash": self.shoe_hash,
            "urdf_hash": self.urdf_hash,
            **({"notes": "\n".join(self.notes)} if self.notes else {}),
        }
        return {**fields, _CHECKSUM: _checksum(fields)}

    @classmethod
    def from_metadata(cls, path: Path, metadata: Mapping[str, str]) -> RunInfo:
        """Read the record.

        Raises:
            VersionError: written by a newer shoecal.
            DamagedError: altered since it was written.
        """
        version = metadata.get("format_version", "")
        if version.isdecimal() and int(version) > FORMAT:
            raise VersionError(path, version, FORMAT)
        fields = {key: value for key, value in metadata.items() if key != _CHECKSUM}
        if metadata.get(_CHECKSUM) != _checksum(fields):
            raise DamagedError(path, f"the record '{RECORD}' fails its checksum")
        try:
            return cls(
                run=int(fields["run"]),
                motion=fields["motion"],
                support=_support(fields["support"]),
                robot=fields["robot"],
                shoe=fields["shoe"],
                robot_hash=fields["robot_hash"],
                shoe_hash=fields["shoe_hash"],
                urdf_hash=fields["urdf_hash"],
                notes=tuple(fields.get("notes", "").splitlines()),
            )
        except (KeyError, ValueError, TypeError, ShoecalError) as error:
            raise RecordingError(
                path, f"the record '{RECORD}' is not one of shoecal's ({error}); record again"
            ) from error


def _support(text: str) -> DoubleSupport | None:
    if not text:
        return None
    dx, dy, dtheta = map(float, text.split())
    return DoubleSupport(dx, dy, dtheta)


def _checksum(fields: Mapping[str, str]) -> str:
    return hashlib.sha256(repr(sorted(fields.items())).encode()).hexdigest()
