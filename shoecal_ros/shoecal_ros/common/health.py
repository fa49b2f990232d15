"""Condition of a node: a line a subject, published when it changes and repeated at a slow rate."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum

from shoecal_core.errors import one_line
from shoecal_ros.common.codes import Code, Problem

AGAIN_S = 5.0
"""A problem that stays the same but for its words is reported again after so long, not before."""


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
        code: for a program; OK where all is well, and nowhere else.
    """

    level: Level
    message: str
    values: Mapping[str, str] = field(default_factory=dict)
    code: str = Code.OK

    def __post_init__(self) -> None:
        if (self.level is Level.OK) != (self.code == Code.OK):
            raise ValueError(f"{self.level.name} with the code '{self.code}': {self.message}")

    @classmethod
    def of(
        cls, problem: Problem | None, well: str, values: Mapping[str, str] | None = None
    ) -> Condition:
        """An error where there is a problem.

        Args:
            problem: what is wrong.
            well: shown where nothing is.
            values: figures for a person.
        """
        if problem is None:
            return cls(Level.OK, well, values or {})
        reported = {**(values or {}), **problem.values}
        return cls(Level.ERROR, problem.message, reported, problem.code)


class Health:
    """The conditions of a node, by subject."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Nothing is known.

        Args:
            clock: monotonic [s].
        """
        self._clock = clock
        self._errors: dict[str, tuple[float, Condition]] = {}
        self._conditions: dict[str, Condition] = {}
        self._fresh: dict[str, Condition] = {}
        self._reported: dict[str, tuple[float, Condition]] = {}

    @property
    def conditions(self) -> Mapping[str, Condition]:
        """By subject, in the order they were first reported."""
        return self._conditions

    def values(self, subject: str) -> dict[str, str]:
        """Its code and figures; once there was a warning or an error, also the last one's."""
        condition = self._conditions[subject]
        values = {"code": str(condition.code), **condition.values}
        if subject in self._errors:
            at, error = self._errors[subject]
            values |= {
                "last_error": error.message,
                "last_error_code": str(error.code),
                "last_error_age_s": f"{self._clock() - at:.0f}",
            }
        return values

    def report(
        self, subject: str, level: Level, message: str, code: Code = Code.OK, **values: object
    ) -> None:
        """Note the condition of a subject."""
        reported = {key: str(value) for key, value in values.items()}
        self.note(subject, Condition(level, message, reported, code))

    def suppose(self, subject: str, condition: Condition) -> None:
        """Its condition unless something else is reported: that is no news."""
        self._conditions[subject] = _clean(condition)

    def note(self, subject: str, condition: Condition) -> None:
        """The same; other figures in the same words are no news."""
        condition = _clean(condition)
        before = self._conditions.get(subject)
        self._conditions[subject] = condition
        if condition.level is not Level.OK:
            self._errors[subject] = (self._clock(), condition)
        if before is None or _words(before) != _words(condition):
            self._fresh[subject] = condition

    def news(self) -> dict[str, Condition]:
        """Conditions that have changed since the last call; mere words of a problem may wait."""
        now = self._clock()
        due = {name: one for name, one in self._fresh.items() if self._due(name, one, now)}
        for subject, condition in due.items():
            del self._fresh[subject]
            self._reported[subject] = now, condition
        return due

    def _due(self, subject: str, condition: Condition, now: float) -> bool:
        if condition.level is Level.OK or subject not in self._reported:
            return True
        at, last = self._reported[subject]
        return now - at >= AGAIN_S or _kind(condition) != _kind(last)


def _clean(condition: Condition) -> Condition:
    return replace(
        condition,
        message=one_line(condition.message),
        values={one_line(key): one_line(value) for key, value in condition.values.items()},
    )


def _kind(condition: Condition) -> tuple[Level, str]:
    """What is news at once where it changes."""
    return condition.level, condition.code


def _words(condition: Condition) -> tuple[Level, str, str]:
    """What is news where it changes."""
    return *_kind(condition), re.sub(r"[-+]?\d+(\.\d+)?", "#", condition.message)
