"""How a node fares: one line a subject, told when it changes and repeated at a slow rate."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum

from shoecal_core.errors import one_line


class Level(IntEnum):
    """As in diagnostic_msgs/msg/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Condition:
    """Of one subject.

    Attributes:
        level: how bad.
        message: one line; where it is bad, with the cure.
        values: figures for a person.
    """

    level: Level
    message: str
    values: Mapping[str, str] = field(default_factory=dict)


class Health:
    """The conditions of a node, by subject."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Nothing is known.

        Args:
            clock: monotonic [s].
        """
        self._clock = clock
        self._errors: dict[str, tuple[float, str]] = {}
        self._conditions: dict[str, Condition] = {}
        self._fresh: dict[str, Condition] = {}

    @property
    def conditions(self) -> Mapping[str, Condition]:
        """By subject, in the order they were first told."""
        return self._conditions

    def values(self, subject: str) -> dict[str, str]:
        """Its figures; once there was a warning or an error, also the last one and its age."""
        values = dict(self._conditions[subject].values)
        if subject in self._errors:
            at, message = self._errors[subject]
            values |= {"last_error": message, "last_error_age_s": f"{self._clock() - at:.0f}"}
        return values

    def tell(self, subject: str, level: Level, message: str, **values: object) -> None:
        """Note how a subject fares."""
        told = {key: str(value) for key, value in values.items()}
        self.note(subject, Condition(level, message, told))

    def suppose(self, subject: str, condition: Condition) -> None:
        """How a subject fares unless something else is told: that is no news."""
        self._conditions[subject] = _clean(condition)

    def note(self, subject: str, condition: Condition) -> None:
        """The same; other figures in the same words are no news."""
        condition = _clean(condition)
        before = self._conditions.get(subject)
        self._conditions[subject] = condition
        if condition.level is not Level.OK:
            self._errors[subject] = (self._clock(), condition.message)
        if (
            before is None
            or before.level is not condition.level
            or _words(before) != _words(condition)
        ):
            self._fresh[subject] = condition

    def news(self) -> dict[str, Condition]:
        """Conditions that have changed since the last call."""
        fresh, self._fresh = self._fresh, {}
        return fresh


def _clean(condition: Condition) -> Condition:
    return Condition(
        condition.level,
        one_line(condition.message),
        {one_line(key): one_line(value) for key, value in condition.values.items()},
    )


def _words(condition: Condition) -> tuple[Level, str]:
    return condition.level, re.sub(r"[-+]?\d+(\.\d+)?", "#", condition.message)
