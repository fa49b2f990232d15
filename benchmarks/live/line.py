"""A serial line on which numbered frames go out at a rate, and the times at which they did."""

from __future__ import annotations

import os
import pty
import time
import tty
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.arrays import IntArray
from shoecal_ros.serial.frame import Frame
from shoecal_ros.serial.protocol import encode_frame

START_S = 0.01
"""From being told to send to the first frame."""


@dataclass(frozen=True)
class Sent:
    """One frame's number, and the monotonic clock just before it was written [ns]."""

    number: int
    at_ns: int


class Line:
    """The device's end of a pseudo-terminal; `path` is the port."""

    def __init__(self, path: Path, counts: IntArray) -> None:
        """Frame k carries the counts (K, n) of row k modulo K."""
        self._line, self._end = pty.openpty()
        tty.setraw(self._end)
        path.symlink_to(os.ttyname(self._end))
        self._counts = [tuple(row) for row in counts.tolist()]
        self._number = 0

    def send(self, rate: float, count: int) -> list[Sent]:
        """Send frames at a rate [Hz]; when each went out."""
        sent = []
        begin = time.monotonic() + START_S
        for index in range(count):
            counts = self._counts[self._number % len(self._counts)]
            due = begin + index / rate
            pause = due - time.monotonic()
            if pause > 0.0:
                time.sleep(pause)
            now_ns = time.monotonic_ns()
            data = encode_frame(
                Frame(
                    sequence=self._number % 2**32,
                    device_time_us=now_ns // 1000,
                    index=tuple(range(len(counts))),
                    status=(0,) * len(counts),
                    counts=counts,
                    temperature=21.5,
                )
            )
            sent.append(Sent(self._number, time.monotonic_ns()))
            os.write(self._line, data)
            self._number += 1
        return sent

    def close(self) -> None:
        """Unplug."""
        os.close(self._line)
        os.close(self._end)
