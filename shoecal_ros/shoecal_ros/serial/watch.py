"""Is a stream alive, and what does it take to make it so?"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence

from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.serial.frame import Event, FaultKind, Frame, FrameFault, Info

RATE_S = 2.0
SAMPLE_BYTES = 256
PRINTABLE = frozenset(b"\t\r\n") | frozenset(range(0x20, 0x7F))
TEXT_SHARE = 0.9


class StreamWatch:
    """Follows what comes in.

    Attributes:
        info: the last one the device sent.
    """

    def __init__(self, monotonic: Callable[[], float] = time.monotonic) -> None:
        self._monotonic = monotonic
        self._last_frame: float | None = None
        self.begin()

    def begin(self) -> None:
        """The stream was opened (again)."""
        self._opened = self._last_byte = self._monotonic()
        self._frames: deque[tuple[float, int]] = deque()
        self._sample = b""
        self._fault: FrameFault | None = None
        self.info: Info | None = None

    def saw(self, data: bytes, events: Sequence[Event]) -> None:
        """Take note of bytes and of what was read from them."""
        now = self._monotonic()
        if data:
            self._last_byte = now
            self._sample = (self._sample + data)[-SAMPLE_BYTES:]
        frames = 0
        for event in events:
            if isinstance(event, Frame):
                frames += 1
            elif isinstance(event, Info):
                self.info = event
            else:
                self._fault = event
        if frames:
            self._last_frame = now
            self._frames.append((now, frames))
            while self._frames[0][0] < now - RATE_S:
                self._frames.popleft()

    @property
    def rate(self) -> float:
        """Good frames per second over the last RATE_S, or since the opening if that is less."""
        now = self._monotonic()
        span = min(RATE_S, now - self._opened)
        recent = sum(frames for when, frames in self._frames.copy() if when >= now - RATE_S)
        return recent / span if span > 0 else 0.0

    @property
    def age(self) -> float | None:
        """Seconds since the last good frame, None before the first."""
        return None if self._last_frame is None else self._monotonic() - self._last_frame

    @property
    def last_fault(self) -> str:
        """What was last not understood, in brackets; empty where all was."""
        return f" (last fault: {self._fault.text})" if self._fault else ""

    def problem(self, alarm_s: float, baud: int, *, text: bool) -> Problem | None:
        """What is wrong and its cure; None when all is well.

        Args:
            alarm_s: so long without a byte, or without a good frame, is a problem [s].
            baud: rate the port was opened with.
            text: whether text lines are expected, rather than binary frames.
        """
        now = self._monotonic()
        silent = now - self._last_byte
        if silent >= alarm_s:
            return Problem(
                Code.PORT_SILENT,
                f"no byte for {silent:.1f} s; check the device's power and cable, and that its "
                "firmware sends by itself",
            )
        useless = now - max(self._opened, self._last_frame or self._opened)
        if useless < alarm_s:
            return None
        reported = f"bytes, but no good frame for {useless:.1f} s"
        if self._fault and self._fault.kind is FaultKind.FOREIGN_VERSION:
            return Problem(Code.FIRMWARE_VERSION, f"{reported}: {self._fault.text}")
        return Problem(Code.PORT_UNREADABLE, f"{reported}: {self._cure(baud, text=text)}")

    def _cure(self, baud: int, *, text: bool) -> str:
        looks_like_text = bool(self._sample) and (
            sum(byte in PRINTABLE for byte in self._sample) >= TEXT_SHARE * len(self._sample)
        )
        last = self.last_fault
        if looks_like_text and not text:
            return "they look like text; set 'mode' to text"
        if looks_like_text:
            return f"correct 'columns', 'time' or 'line' under 'text'{last}"
        if text:
            return f"they are no text; correct 'baud' (now {baud}) or set 'mode' to binary"
        return f"correct 'baud' (now {baud}), or 'mode' (now binary){last}"
