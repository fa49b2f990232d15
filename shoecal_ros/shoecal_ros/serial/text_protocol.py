"""Text lines as hobby firmware prints them: numbers in columns, with chatter in between."""

from __future__ import annotations

import math
import re
from enum import Enum

from shoecal_ros.serial.continuity import Continuity
from shoecal_ros.serial.errors import FrameError
from shoecal_ros.serial.frame import (
    SEQUENCE_MODULUS,
    ChannelStatus,
    Event,
    Fault,
    FaultKind,
    Frame,
    LinkCounts,
)

MAX_LINE = 1024

_LINE_END = re.compile(rb"[\r\n]")
# Possessive quantifiers (`++`): a long line of digits or blanks must not take longer than it needs
# on the wire.
_NAMING = re.compile(r"(?<!\s)\s*+[=:]\s*+")
_SEPARATOR = re.compile(r"\s*+[,;]\s*+|\s++")
_NUMBER = r"[+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?"
_COLUMN = re.compile(rf"(?:[A-Za-z_][\w./\[\]-]*+=)?({_NUMBER})\Z")
_NO_NUMBER = re.compile(r"(?:[A-Za-z_][\w./\[\]-]*=)?[+-]?(?:nan|inf|ovf)\Z", re.IGNORECASE)

_COUNTER_US = 2**32
"""millis() and micros() of small controllers are 32 bits wide and wrap around."""
_WRAP_MARGIN = 2**28


class TextTime(Enum):
    """What the first column of a line is."""

    NONE = "none"
    MILLISECONDS = "ms"
    MICROSECONDS = "us"


class TextDecoder:
    """Incremental decoder of lines; holds at most MAX_LINE bytes.

    A frame's sequence counts the lines understood, so lost lines are not seen. Nothing guards
    a line against flipped bits except its number of columns.
    """

    def __init__(self, time: TextTime = TextTime.NONE, columns: int | None = None) -> None:
        """Columns: how many values a line must have, the time not counted; None: any number."""
        self._counts = LinkCounts()
        self._continuity = Continuity(numbered=False)
        self._time = time
        self._columns = columns
        self._sequence = 0
        self._ticks: int | None = None
        self._turns = 0
        self._partial = b""
        self._whole = False

    @property
    def counts(self) -> LinkCounts:
        """Totals so far."""
        return self._counts

    @property
    def pending(self) -> int:
        """Bytes that wait for the rest of their frame."""
        return len(self._partial)

    def resume(self) -> None:
        """Forget a half-read line: the next bytes start anywhere in the stream."""
        self._counts.skipped_bytes += len(self._partial)
        self._partial = b""
        self._whole = False

    def feed(self, data: bytes) -> list[Event]:
        """Events that these bytes complete."""
        self._counts.bytes += len(data)
        *complete, rest = _LINE_END.split(data)
        events: list[Event] = []
        for piece in complete:
            self._extend(piece)
            self._finish(events)
        self._extend(rest)
        for event in events:
            self._counts.add(event)
        return events

    def _extend(self, piece: bytes) -> None:
        if len(self._partial) + len(piece) > MAX_LINE:
            self._counts.skipped_bytes += len(self._partial) + len(piece)
            self._partial = b""
            self._whole = False
        else:
            self._partial += piece

    def _finish(self, events: list[Event]) -> None:
        """Read one line; one whose beginning was not seen could be a cut number."""
        line, self._partial = self._partial, b""
        whole, self._whole = self._whole, True
        if not line.strip():
            return
        event = self._parse(line) if whole else None
        if isinstance(event, Frame):
            events += self._continuity.check(event)
        else:
            self._counts.skipped_bytes += len(line)
        if event is not None:
            events.append(event)

    def _parse(self, line: bytes) -> Event:
        text = line.decode("ascii", errors="replace").strip()
        numbers = _numbers(text)
        if numbers is None:
            return Fault(FaultKind.CHATTER, f"no numbers only: {text[:60]!r}")
        timed = self._time is not TextTime.NONE
        values = numbers[1:] if timed else numbers
        if not values or (self._columns is not None and len(values) != self._columns):
            wanted = "some" if self._columns is None else str(self._columns)
            return Fault(
                FaultKind.BAD_LENGTH,
                f"{len(values)} values{' after the time' if timed else ''}, "
                f"expected {wanted}: {text[:60]!r}",
            )
        time_us = self._device_time(numbers[0]) if timed else None
        if timed and time_us is None:
            return Fault(FaultKind.BAD_CONTENT, f"first column is no device time: {text[:60]!r}")
        return self._frame(time_us, values)

    def _frame(self, time_us: int | None, values: list[float]) -> Event:
        missing = [not math.isfinite(value) for value in values]
        try:
            frame = Frame(
                sequence=self._sequence,
                device_time_us=time_us,
                index=tuple(range(len(values))),
                status=tuple(
                    ChannelStatus.NO_DATA if gone else ChannelStatus.GOOD for gone in missing
                ),
                counts=tuple(
                    0.0 if gone else value for gone, value in zip(missing, values, strict=True)
                ),
            )
        except FrameError as error:
            return Fault(FaultKind.BAD_CONTENT, str(error))
        self._sequence = (self._sequence + 1) % SEQUENCE_MODULUS
        return frame

    def _device_time(self, ticks: float) -> int | None:
        """Device time [us] of a time column, carried on where a 32-bit counter wraps around."""
        if not 0 <= ticks < 2**52:
            return None
        scale = 1000 if self._time is TextTime.MILLISECONDS else 1
        last, self._ticks = self._ticks, int(ticks)
        if last is not None and ticks < last:
            wrapped = last >= _COUNTER_US - _WRAP_MARGIN and ticks < _WRAP_MARGIN
            self._turns = self._turns + 1 if wrapped and last < _COUNTER_US else 0
        return round(ticks * scale) + self._turns * _COUNTER_US * scale


def _numbers(text: str) -> list[float] | None:
    """Values of a line's columns, NaN where the firmware printed none; None for anything else."""
    values = []
    for column in _SEPARATOR.split(_NAMING.sub("=", text).rstrip(",; \t")):
        match = _COLUMN.match(column)
        if match is not None:
            values.append(float(match.group(1)))
        elif _NO_NUMBER.match(column):
            values.append(math.nan)
        else:
            return None
    return values
