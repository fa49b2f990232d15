"""Runs as session.yaml lists them."""

from __future__ import annotations

import re
from dataclasses import dataclass

from shoecal_core.errors import ShoecalError
from shoecal_core.files import Fields
from shoecal_core.recording.writer import PART
from shoecal_core.robot.double_support import DoubleSupport

HINTS = ("", "train", "test")
"""What a run may be meant for."""

RUN_FILE = re.compile(rf"run_([0-9]{{3,9}})\.mcap({re.escape(PART)})?")
"""Names of run files: number, and the suffix of unfinished ones."""


@dataclass(frozen=True)
class ListedRun:
    """A run as session.yaml lists it: from its start on, so that a person finds it there."""

    run: int
    motion: str
    support: DoubleSupport | None
    hint: str

    @property
    def file(self) -> str:
        """Name of its file."""
        return run_file(self.run)

    def to_yaml(self) -> dict[str, object]:
        """Fields of the list."""
        support = self.support
        place = (support.dx, support.dy, support.dtheta) if support else None
        return {
            "file": self.file,
            "motion": self.motion,
            "support": place and [float(value) for value in place],
            "set": self.hint,
        }


def read_listed(item: Fields) -> ListedRun:
    """Read one item of the list.

    Raises:
        FieldError: for a file name or field that is wrong.
    """
    item.only("file", "motion", "support", "set")
    match = RUN_FILE.fullmatch(item.text("file"))
    if match is None:
        raise item.error("file", "is no name of a run; expected run_001.mcap or the like")
    return ListedRun(
        run=int(match[1]),
        motion=item.text("motion"),
        support=read_support(item),
        hint=item.choice("set", dict.fromkeys(HINTS)),
    )


def read_support(fields: Fields) -> DoubleSupport | None:
    """`support`, three numbers of a file; None without it. FileError where they are wrong."""
    key = "support"
    if key not in fields:
        return None
    numbers = fields.array(key, (3,))
    try:
        return DoubleSupport(*map(float, numbers))
    except ShoecalError as error:
        raise fields.error(key, str(error)) from error


def run_file(run: int) -> str:
    """Name of a run's file."""
    return f"run_{run:03d}.mcap"
