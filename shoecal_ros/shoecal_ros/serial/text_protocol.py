"""Text lines as hobby firmware prints them: numbers in columns, with chatter in between."""

from __future__ import annotations

import math
import re
from enum import Enum

from shoecal_ros.serial.continuity import Continuity
from shoecal_ros.serial.decoder import Decoder
from shoecal_ros.serial.errors import FrameError
from shoecal_ros.serial.frame import (
    SEQUENCE_MODULUS,
    ChannelStatus,
    Event,
    FaultKind,
    Frame,
    FrameFault,
)
from shoecal_ros.serial.line_form import LineForm

MAX_LINE = 1024

_LINE_END = re.compile(rb"[\r\n]")
# Possessive quantifiers (`++`): a long line of digits or blanks must not take longer than it needs
# on the wire.
_NAMING = re.compile(r"(?<!\s)\s*+[=:]\s*+")
_SEPARATOR = re.compile(r"\s*+[,;]\s*+|\s++")
_NUMBER = r"[+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?"
_COLUMN = re.compile(rf"(?:[A-Za-z_][\w./\[\]-]*+=)?({_NUMBER})\Z")
_NO_NUMBER = re.compile(r"(?:[A-Za-z_][\w./\[\]-]*=)?[+-]?(?:nan|inf|ovf)\Z", re.IGNORECASE)

_COUNTER = 2**32
"""millis() and micros() of small controllers wrap around there; printed with a sign (`%d`, `long`),
they go on at -2^31, the same modulo 2^32."""
_WRAP_MARGIN = 2**28
"""Ticks that may be lost where they wrap."""
_NARROW = (2**16, 2**24, 2**31)
"""Where counters wrap that firmware keeps in fewer bits."""
_LOST_STEPS = 16
"""Steps like the last one that may be lost where a narrow counter wraps: more is a device that
started again."""


class TextTime(Enum):
    """What the first column of a line is."""

    NONE = "none"
    MILLISECONDS = "ms"
    MICROSECONDS = "us"


class TextDecoder(Decoder):
    """Of lines.

    A frame's sequence counts the lines understood, so lost lines are not seen. Nothing guards
    a line against flipped bits except its number of columns.
    """

    longest = MAX_LINE
    sealed = False

    def __init__(
        self,
        time: TextTime = TextTime.NONE,
        columns: int | None = None,
        form: LineForm | None = None,
    ) -> None:
        """Of lines of one form.

        Args:
            time: what the first number of a line is.
            columns: how many values a line must have, the time not counted; None: any number.
            form: of lines with words next to the numbers; None: numbers and their names alone.
        """
        super().__init__(Continuity(numbered=False))
        self._time = time
        self._columns = columns
        self._form = form
        self._sequence = 0
        self._ticks: int | None = None
        self._step = 0
        self._carry = 0

    def split(self, data: bytes) -> list[bytes]:
        """At ends of lines, of whatever system."""
        return _LINE_END.split(data)

    def read(self, piece: bytes) -> Event | None:
        """One line; None for an empty one."""
        text = piece.decode("ascii", errors="replace").strip()
        if not text:
            return None
        numbers = _numbers(text) if self._form is None else self._form.numbers(text)
        if numbers is None:
            return FrameFault(FaultKind.CHATTER, f"{self._chatter}: {text[:60]!r}")
        timed = self._time is not TextTime.NONE
        values = numbers[1:] if timed else numbers
        if not values or (self._columns is not None and len(values) != self._columns):
            wanted = "some" if self._columns is None else str(self._columns)
            return FrameFault(
                FaultKind.BAD_LENGTH,
                f"{len(values)} values{' after the time' if timed else ''}, "
                f"expected {wanted}: {text[:60]!r}",
            )
        time_us = self._device_time(numbers[0]) if timed else None
        if timed and time_us is None:
            return FrameFault(
                FaultKind.BAD_CONTENT, f"first column is no device time: {text[:60]!r}"
            )
        return self._frame(time_us, values)

    @property
    def _chatter(self) -> str:
        """What a line is that is not understood."""
        if self._form is not None:
            return f"not of the form '{self._form.text}'"
        return "words between the numbers (print numbers alone, or give 'text.line')"

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
            return FrameFault(FaultKind.BAD_CONTENT, str(error))
        self._sequence = (self._sequence + 1) % SEQUENCE_MODULUS
        return frame

    def _device_time(self, ticks: float) -> int | None:
        """Device time [us] of a time column, carried on where the device's counter wraps around."""
        if not -_COUNTER // 2 <= ticks < 2**52:
            return None
        now = round(ticks)
        last, self._ticks = self._ticks, now
        if last is None or (now < last and not (around := self._around(now - last))):
            # The device starts: a negative counter is one with a sign.
            self._carry = _COUNTER if now < 0 else 0
        elif now < last:
            self._carry += around
        else:
            self._step = now - last
        scale = 1000 if self._time is TextTime.MILLISECONDS else 1
        return round((ticks + self._carry) * scale)

    def _around(self, back: int) -> int:
        """Ticks after which the counter that went back by `back` starts over; 0 if it did not."""
        if 0 <= back + _COUNTER < _WRAP_MARGIN:
            return _COUNTER
        narrow = _LOST_STEPS * self._step
        return next((one for one in _NARROW if 0 < back + one <= narrow), 0)


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
