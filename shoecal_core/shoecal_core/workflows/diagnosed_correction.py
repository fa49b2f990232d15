"""What a diagnosis found of the robot itself, in copies of its files."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.diagnosis.result import FORMAT, VERDICT_TEXTS
from shoecal_core.errors import FieldError, FileSyntaxError
from shoecal_core.files import Fields, read_bytes
from shoecal_core.recording.session import Session
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.workflows.model_correction import Corrected, Found, corrected_files

NAMED = ("explained", "partly_explained")
"""Verdicts whose causes files are corrected by."""
COMPONENTS: Mapping[str, tuple[str, ...]] = {
    "joint_offset": ("angle",),
    "payload": ("mass",),
    "total_mass": ("mass",),
    "link_com": ("x", "y", "z"),
    "joint_compliance": ("compliance",),
    "backlash": ("play",),
    "latency": ("delay",),
}
"""Effects that belong into files, and their sizes."""
_OF_95 = 3.92
"""Width of an interval of 95 %, in standard deviations."""


@dataclass(frozen=True)
class Diagnosed:
    """Causes of a diagnosis.

    Attributes:
        found: those that belong into files.
        left: those that do not, in words.
        cop_mae_mm: mean error of the CoP on test runs without and with all causes [mm].
    """

    found: tuple[Found, ...]
    left: tuple[str, ...]
    cop_mae_mm: tuple[float, float]


def correct_by_diagnosis(
    session: Session, diagnosis: Path, mjcf: Path | None = None
) -> tuple[Corrected, Diagnosed]:
    """Copies of a session's robot file, URDF and MJCF with a diagnosis's causes.

    The diagnosis has tested them on runs of its own; nothing is fitted here.

    Args:
        session: that was diagnosed.
        diagnosis: what `shoecal diagnose --json` wrote of it.
        mjcf: of the same robot.

    Raises:
        FieldError: of a diagnosis that names no cause, none that belongs into files, or is of
            another robot.
        MjcfError: of an MJCF that is not of this robot.
    """
    found = read_causes(diagnosis, load_robot(session.robot_yaml).name)
    return corrected_files(session, found.found, mjcf), found


def read_causes(path: Path, robot: str) -> Diagnosed:
    """Causes in a file of `shoecal diagnose --json`.

    Args:
        path: of the file.
        robot: name of the robot that it has to be of.
    """
    fields = _read(path)
    fields.format(FORMAT)
    if "sessions" in fields:
        raise fields.error("sessions", "holds several diagnoses; diagnose the session alone")
    verdicts = {str(name): text for name, text in VERDICT_TEXTS.items()}
    verdict = fields.choice("verdict", verdicts)
    if verdict not in NAMED:
        problem = f"is {verdict}: {verdicts[verdict]}; nothing to correct files by"
        raise fields.error("verdict", f"{problem}; it must be {' or '.join(NAMED)}")
    if (other := fields.text("robot")) != robot:
        raise fields.error("robot", f"is {other}, and the session's is {robot}; name its session")
    found: list[Found] = []
    left: list[str] = []
    for cause in fields.items("causes"):
        effect, location = cause.text("effect"), tuple(cause.texts("location"))
        if effect not in COMPONENTS or "run" in cause:
            when = f" in run {cause.integer('run')}" if "run" in cause else ""
            place = f" ({', '.join(location)})" if location else ""
            left.append(f"{effect}{place}{when}: not of the robot's files")
        else:
            found += _sizes(cause, effect, location)
    if not found:
        raise FieldError(
            path,
            f"none belongs into the robot's files ({'; '.join(left) or 'there is none'}); these "
            f"do: {', '.join(COMPONENTS)}",
            field="causes",
        )
    whole = fields if "shrink" in fields else fields.items("causes")[0]
    before, after = whole.mapping("shrink").array("cop_mae_mm", (2,))
    return Diagnosed(tuple(found), tuple(left), (float(before), float(after)))


def _read(path: Path) -> Fields:
    try:
        value = json.loads(read_bytes(path))
    except ValueError as error:
        raise FileSyntaxError(
            path, f"no JSON ({error}); name a file of `diagnose --json`"
        ) from error
    if not isinstance(value, dict):
        raise FileSyntaxError(path, "no diagnosis; name a file of `shoecal diagnose --json`")
    if isinstance(failure := value.get("error"), dict):
        raise FieldError(
            path,
            f"this diagnosis failed ({failure.get('message', '')}); diagnose again",
            field="error",
        )
    return Fields(path, "", value)


def _sizes(cause: Fields, effect: str, location: tuple[str, ...]) -> Iterator[Found]:
    sizes = cause.mapping("size")
    for name in COMPONENTS[effect]:
        if name in sizes:
            size = sizes.mapping(name)
            low, high = size.array("ci95", (2,))
            yield Found(
                effect, location, name, size.text("unit"), size.number("value"),
                float(high - low) / _OF_95,
            )  # fmt: skip
