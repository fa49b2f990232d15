"""Readings as lines of text: JSON or CSV, from a file, a pipe, or the running driver.

A JSON line is `{"stamp_ns": 1, "cells": ["left/front_left"], "voltages": [0.1], "status": [0]}`;
`stamp_ns` and `status` may be left out, null stands for a reading that was not given. A line
`{"problem": "..."}` says why there are none. CSV begins with the names of its columns: cells, and
`stamp_ns` where there is one. A line may hold any of the cells.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FieldError
from shoecal_core.shoe.shoe import Shoe

STAMP = "stamp_ns"
_HUGE = 1e100
_NOTHING_GIVEN = (2, 3)
"""Statuses of ShoeVoltages whose voltage means nothing: no data, fault."""


@dataclass(frozen=True)
class LineFrame:
    """All channels at one instant.

    Attributes:
        readings: (n,) in the shoe's order, NaN where none was given.
        stamp_ns: when they were sampled, 0 where unknown.
    """

    readings: FloatArray
    stamp_ns: int


@dataclass(frozen=True)
class LineProblem:
    """Why no readings come."""

    text: str


class FrameParser:
    """Turns one line after the other into frames."""

    def __init__(self, shoe: Shoe, path: Path) -> None:
        """At the beginning.

        Args:
            shoe: whose cells they are of.
            path: where the lines come from, for messages.
        """
        self._shoe = shoe
        self._path = path
        self._line = 0
        self._columns: list[str] | None = None

    def parse(self, text: str) -> LineFrame | LineProblem | None:
        """One line; None where it holds no readings.

        Raises:
            FieldError: with the number of the line.
        """
        self._line += 1
        text = text.strip()
        if not text:
            return None
        if text.startswith("{"):
            return self._json(text)
        names = [part.strip() for part in text.split(",")]
        if self._columns is None:
            for name in names:
                if name != STAMP:
                    self._index(name)
            self._columns = names
            return None
        return self._csv(names, self._columns)

    def _json(self, text: str) -> LineFrame | LineProblem:
        try:
            value = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise self._error(f"no JSON ({error}); correct its sender") from error
        if isinstance(value.get("problem"), str):
            return LineProblem(value["problem"])
        cells, voltages = (value.get(key) for key in ("cells", "voltages"))
        status = value.get("status", [0] * len(cells) if isinstance(cells, list) else None)
        lists = (cells, voltages, status)
        if not all(isinstance(one, list) for one in lists) or len({*map(len, lists)}) != 1:
            raise self._error("needs 'cells' and 'voltages' (and 'status') of equal length")
        stamp = value.get(STAMP, 0)
        if isinstance(stamp, bool) or not isinstance(stamp, int) or stamp < 0:
            raise self._error(f"{STAMP} must be whole nanoseconds")
        pairs = [
            (name, math.nan if state in _NOTHING_GIVEN or voltage is None else voltage)
            for name, voltage, state in zip(*lists, strict=True)
        ]
        return self._frame(pairs, stamp)

    def _csv(self, parts: list[str], columns: list[str]) -> LineFrame:
        if len(parts) != len(columns):
            raise self._error(f"{len(parts)} values for {len(columns)} columns")
        values = dict(zip(columns, parts, strict=True))
        stamp = values.pop(STAMP, "") or "0"
        if not stamp.isdecimal():
            raise self._error(f"{STAMP} '{stamp}' must be whole nanoseconds")
        pairs: list[tuple[str, object]] = []
        for name, part in values.items():
            try:
                pairs.append((name, float(part) if part else math.nan))
            except ValueError:
                raise self._error(f"'{part}' of {name} is no number") from None
        return self._frame(pairs, int(stamp))

    def _frame(self, pairs: list[tuple[str, object]], stamp_ns: int) -> LineFrame:
        readings = np.full(len(self._shoe.names), math.nan)
        for name, value in pairs:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise self._error(f"the reading of {name} is no number")
            # Beyond all converters, and perhaps beyond what a float can hold.
            readings[self._index(name)] = float(value) if abs(value) < _HUGE else math.nan
        if stamp_ns >= 2**63:
            raise self._error(f"{STAMP} {stamp_ns} is no time")
        return LineFrame(readings, stamp_ns)

    def _index(self, name: str) -> int:
        if name not in self._shoe.names:
            raise self._error(
                f"'{name}' is no cell of {self._shoe.path} (there are: "
                f"{', '.join(self._shoe.names)})"
            )
        return self._shoe.names.index(name)

    def _error(self, problem: str) -> FieldError:
        return FieldError(self._path, problem, field=f"line {self._line}")
