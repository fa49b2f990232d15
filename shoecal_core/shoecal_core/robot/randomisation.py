"""What a simulator should vary of a robot, and by how much: `randomisation.yaml`.

Every value is of the robot minus its *nominal* file: the mean is what to add to the file that a
session was recorded with, the standard deviation what is not known of it. In the corrected files
the means are already; there the standard deviations alone are left, about zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.errors import FieldError
from shoecal_core.files import Fields, read_yaml, yaml_text

FORMAT = 1
JOINT_ZERO, MASS, COMPLIANCE, PLAY, LATENCY = "joint_zero", "mass", "compliance", "play", "latency"
COM = ("com_x", "com_y", "com_z")
UNITS: Mapping[str, str] = {
    JOINT_ZERO: "rad",
    MASS: "kg",
    **dict.fromkeys(COM, "m"),
    COMPLIANCE: "rad/(N m)",
    PLAY: "rad",
    LATENCY: "s",
}
"""Kinds of parameters."""


@dataclass(frozen=True)
class Parameter:
    """One number of a robot, as the difference from its nominal file.

    Attributes:
        kind: joint_zero: reading of the encoder minus angle of the link; mass: of a link and all
            that is fixed to it; com_x, com_y, com_z: of their CoM, in the link's frame;
            compliance: between encoder and link; play: the whole dead band; latency: age of a
            foot's readings.
        at: joint or link as URDF and MJCF name it; `left` or `right` for a latency.
        mean, std: of its posterior, in the kind's unit (`UNITS`), regardless of other parameters.
    """

    kind: str
    at: str
    mean: float
    std: float

    @property
    def unit(self) -> str:
        """Of mean and standard deviation."""
        return UNITS[self.kind]


@dataclass(frozen=True)
class Randomisation:
    """All that was found of one robot.

    Attributes:
        robot: its name.
        parameters: each kind and place once.
    """

    robot: str
    parameters: tuple[Parameter, ...]

    def of(self, kind: str) -> dict[str, Parameter]:
        """Those of one kind, by place."""
        return {one.at: one for one in self.parameters if one.kind == kind}

    def text(self) -> str:
        """The file's content."""
        return yaml_text(
            {
                "format": FORMAT,
                "robot": self.robot,
                "parameters": [
                    {
                        "kind": one.kind,
                        "at": one.at,
                        "unit": one.unit,
                        "mean": one.mean,
                        "std": one.std,
                    }
                    for one in self.parameters
                ],
            }
        )


def load_randomisation(path: Path) -> Randomisation:
    """Read a `randomisation.yaml`.

    Raises:
        FileError: for what is missing, unknown, or given twice, naming file and field.
    """
    fields = read_yaml(path)
    fields.only("format", "robot", "parameters")
    fields.format(FORMAT)
    parameters: dict[tuple[str, str], Parameter] = {}
    for item in fields.items("parameters"):
        one = _parameter(item)
        if (one.kind, one.at) in parameters:
            raise FieldError(path, f"{one.kind} of {one.at} is there twice; keep one", field="at")
        parameters[one.kind, one.at] = one
    return Randomisation(fields.text("robot"), tuple(parameters.values()))


def _parameter(item: Fields) -> Parameter:
    item.only("kind", "at", "unit", "mean", "std")
    kind = item.choice("kind", UNITS)
    if item.text("unit") != UNITS[kind]:
        raise item.error("unit", f"must be {UNITS[kind]} for {kind}")
    return Parameter(kind, item.text("at"), item.number("mean"), item.number("std", minimum=0.0))
