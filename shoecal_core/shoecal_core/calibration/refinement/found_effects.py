"""What a diagnosis found, read from its JSON file."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.errors import FileSyntaxError
from shoecal_core.files import Fields, read_bytes

FORMAT = 1
STD_95 = 1.96
"""Half the width of a 95 % interval, in standard deviations."""
SURE_FROM = 0.9
"""A cause of this probability on is taken for sure where the gap is explained."""


@dataclass(frozen=True)
class FoundEffect:
    """One cause, with what is believed of its size.

    Attributes:
        effect: identifier.
        location: cells, feet, joints or links; `all`; empty.
        size: mean and standard deviation by component, in SI units.
        probability: that it is there.
    """

    effect: str
    location: tuple[str, ...]
    size: Mapping[str, tuple[float, float]]
    probability: float = 1.0

    @property
    def label(self) -> str:
        """For a person to read."""
        return f"{self.effect} ({', '.join(self.location)})" if self.location else self.effect


@dataclass(frozen=True)
class FoundEffects:
    """The explanation that a diagnosis chose.

    Attributes:
        robot, shoe: names of those that were diagnosed.
        verdict: of the diagnosis.
        effects: its causes.
    """

    robot: str
    shoe: str
    verdict: str
    effects: tuple[FoundEffect, ...]

    def sure(self, effect: FoundEffect) -> bool:
        """Whether the diagnosis leaves no doubt of one of its causes."""
        return self.verdict == "explained" and effect.probability >= SURE_FROM


def load_found_effects(path: Path) -> FoundEffects:
    """Read what `shoecal diagnose --json` wrote of one session.

    Raises:
        FileError: for a file that is no diagnosis of one session.
    """
    try:
        told = json.loads(read_bytes(path))
    except (ValueError, RecursionError) as error:  # of the syntax, the encoding, endless digits
        raise FileSyntaxError(
            path, "is no JSON file; give what `shoecal diagnose --json` wrote"
        ) from error
    if not isinstance(told, dict) or "causes" not in told:
        problem = "is no diagnosis of one session; give what `shoecal diagnose --json` wrote"
        raise FileSyntaxError(path, problem)
    fields = Fields(path, "", told)
    fields.format(FORMAT)
    return FoundEffects(
        robot=fields.text("robot"),
        shoe=fields.text("shoe"),
        verdict=fields.text("verdict"),
        effects=tuple(_effect(item) for item in fields.items("causes")),
    )


def _effect(fields: Fields) -> FoundEffect:
    sizes = fields.mapping("size")
    size = {}
    for name in sizes.keys():
        one = sizes.mapping(name)
        low, high = one.array("ci95", (2,))
        if not high >= low:
            raise one.error("ci95", "must be the lower end first")
        size[name] = (one.number("value"), float(high - low) / 2.0 / STD_95)
    return FoundEffect(
        effect=fields.text("effect"),
        location=tuple(fields.texts("location")),
        size=size,
        probability=fields.number("probability"),
    )
