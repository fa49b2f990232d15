"""Frames from a log of raw bytes, at the pace of the device's clock."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from pathlib import Path

from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.serial.decoder import Decoder
from shoecal_ros.serial.errors import ReplayError
from shoecal_ros.serial.frame import Event, Frame
from shoecal_ros.serial.source import Received, SourceStatus
from shoecal_ros.serial.watch import StreamWatch

CHUNK_BYTES = 4096
LONGEST_PAUSE_US = 60_000_000
"""A device time further ahead is a clock that jumped; it is not waited for."""


class ReplaySource:
    """Gives the frames of a log as they would come from the device.

    Their time of receipt is the start plus the device time gone by. It knows nothing of the
    delays there were: a log holds bytes only.
    """

    def __init__(
        self,
        path: Path,
        decoder: Decoder,
        now: Callable[[], int],
        *,
        start_ns: int | None = None,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        """A replay that has not begun.

        Args:
            path: file of bytes as a SerialSource logs them.
            decoder: of those bytes.
            now: the host's clock [ns]; a frame is given once this clock is past its receipt.
            start_ns: receipt of the first frame; None: when it is read.
            monotonic: clock for the rate [s].

        Raises:
            ReplayError: when there is no such file.
        """
        self._path, self._decoder, self._now = path, decoder, now
        self._receive_ns = start_ns
        self._device_us: int | None = None
        self._waiting: deque[Received] = deque()
        self._watch = StreamWatch(monotonic)
        self._closed = threading.Event()
        self._reading = threading.Lock()
        try:
            self._file = path.open("rb")
        except OSError as error:
            reported = f"{path}: cannot be read ({error.strerror}); correct 'port'"
            raise ReplayError(reported) from error

    def open(self) -> None:
        """Nothing to do: the file is open."""

    def read(self, timeout_s: float) -> list[Received]:
        """What is due by now, in order; waits at most `timeout_s` for something to be due.

        Raises:
            ReplayError: when the lines carry no device time, so that their pace is not known.
        """
        with self._reading:
            if not self._waiting and not self._closed.is_set():
                self._load()
            if not self._waiting:
                self._closed.wait(timeout_s)
                return []
            ahead_s = (self._waiting[0].receive_ns - self._now()) / 1e9
            if ahead_s > 0:
                self._closed.wait(min(ahead_s, timeout_s))
            due = []
            now_ns = self._now()
            while self._waiting and self._waiting[0].receive_ns <= now_ns:
                due.append(self._waiting.popleft())
            self._watch.saw(b"", [received.event for received in due])
            return due

    def status(self) -> SourceStatus:
        """How far the replay is."""
        ended = self._closed.is_set()
        if self._watch.age is None:
            state = f"has no good frame: correct 'mode' or 'text'{self._watch.last_fault}"
        else:
            state = "replayed to its end; start the driver again to replay it once more"
        reported = Problem(Code.REPLAY_ENDED, f"{self._path}: {state}")
        return SourceStatus(
            name=str(self._path),
            connected=not ended,
            rate=self._watch.rate,
            age=self._watch.age,
            counts=self._decoder.counts.copy(),
            reconnects=0,
            info=self._watch.info,
            problem=reported if ended else None,
        )

    def close(self) -> None:
        """End the replay."""
        self._closed.set()
        with self._reading:
            self._waiting.clear()
            self._file.close()

    def _load(self) -> None:
        """Decode on until an event comes or the file ends."""
        while not self._waiting:
            data = self._file.read(CHUNK_BYTES)
            if not data:
                self._closed.set()
                return
            for event in self._decoder.feed(data):
                self._waiting.append(Received(event, self._receipt(event)))

    def _receipt(self, event: Event) -> int:
        if self._receive_ns is None:
            self._receive_ns = self._now()
        if isinstance(event, Frame):
            if event.device_time_us is None:
                raise ReplayError(
                    f"{self._path}: its lines carry no device time, so their pace is lost; "
                    "log from firmware that prints one"
                )
            if self._device_us is not None:
                pause_us = max(0, event.device_time_us - self._device_us)
                self._receive_ns += min(pause_us, LONGEST_PAUSE_US) * 1000
            self._device_us = event.device_time_us
        return self._receive_ns
