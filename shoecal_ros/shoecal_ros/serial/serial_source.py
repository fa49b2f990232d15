"""Frames from a serial port, which may be unplugged and plugged in again."""

from __future__ import annotations

import os
import select
import threading
import time
from collections.abc import Callable
from pathlib import Path

import serial

from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.serial.decoder import Decoder
from shoecal_ros.serial.errors import PortError
from shoecal_ros.serial.port import PORT_TROUBLE, open_port
from shoecal_ros.serial.protocol import INFO_REQUEST, BinaryDecoder
from shoecal_ros.serial.raw_log import RawLog
from shoecal_ros.serial.source import Received, SourceStatus
from shoecal_ros.serial.watch import StreamWatch

READ_BYTES = 4096
BACKLOG_BYTES = 65536
PAUSES_S = (0.0, 0.1, 0.2, 0.4)
"""Before each attempt to open a port that is gone; the last one repeats."""
REQUEST_S = 1.0
REQUESTS = 5
"""The device is asked so often what it is; old firmware may not answer."""


class SerialSource:
    """Reads a serial port and opens it again by itself when it was unplugged.

    One thread reads; status and close may come from others.
    """

    def __init__(
        self,
        port: str,
        baud: int,
        decoder: Decoder,
        now: Callable[[], int],
        *,
        alarm_s: float,
        raw_log: Path | None = None,
        monotonic: Callable[[], float] = time.monotonic,
    ) -> None:
        """A source that is not open yet.

        Args:
            port: device file; one under /dev/serial/by-id keeps its name.
            baud: bits per second.
            decoder: of what the device sends.
            now: the host's clock [ns] that stamps what is received.
            alarm_s: so long without a byte, or without a good frame, is a problem [s].
            raw_log: file to which every byte received is appended.
            monotonic: clock for rates, alarms and pauses [s].

        Raises:
            FileError: when the log cannot be opened.
        """
        self._name, self._baud, self._decoder = port, baud, decoder
        self._now, self._monotonic, self._alarm_s = now, monotonic, alarm_s
        self._log = RawLog(raw_log) if raw_log is not None else None
        self._watch = StreamWatch(monotonic)
        self._port: serial.Serial | None = None
        self._trouble = self._reported(Code.PORT_NOT_OPEN, "not opened yet; wait")
        self._openings = self._failures = self._requests = 0
        self._next_request = self._next_attempt = -float("inf")
        self._closed = threading.Event()
        self._reading = threading.Lock()
        self._state = threading.Lock()

    def open(self) -> None:
        """Open the port now.

        Raises:
            PortError: see `open_port`.
        """
        with self._reading:
            if self._port is None:
                self._open()

    def read(self, timeout_s: float) -> list[Received]:
        """Frames, device facts and faults, in order; waits at most `timeout_s` for bytes.

        A port that is gone is tried again at growing intervals; `status` reports it meanwhile.
        """
        with self._reading:
            if self._closed.is_set() or not (self._port or self._reopened(timeout_s)):
                return []
            try:
                data = self._wait(timeout_s)
            except PORT_TROUBLE as error:
                self._lose(error)
                return []
            if not data:
                return []
            receive_ns = self._now()
            with self._state:
                events = self._decoder.feed(data)
                self._watch.saw(data, events)
                if self._log is not None:
                    self._log.write(data)
            self._ask()
            return [Received(event, receive_ns) for event in events]

    def status(self) -> SourceStatus:
        """Condition of the port."""
        with self._state:
            connected = self._port is not None
            problem: Problem | None = self._trouble
            if connected:
                text = not isinstance(self._decoder, BinaryDecoder)
                found = self._watch.problem(self._alarm_s, self._baud, text=text)
                problem = found and self._reported(found.code, found.message)
            if problem is None and self._log is not None:
                problem = self._log.problem
            return SourceStatus(
                name=self._name,
                connected=connected,
                rate=self._watch.rate,
                age=self._watch.age,
                counts=self._decoder.counts.copy(),
                reconnects=max(0, self._openings - 1),
                info=self._watch.info,
                problem=problem,
            )

    def close(self) -> None:
        """Close port and log, once a read in progress has ended."""
        self._closed.set()
        with self._reading:
            self._release(self._reported(Code.PORT_CLOSED, "closed; start the driver again"))
            if self._log is not None:
                self._log.close()

    def _open(self) -> None:
        port = open_port(self._name, self._baud)
        with self._state:
            self._port = port
            self._openings += 1
            self._failures = self._requests = 0
            self._decoder.resume()
            self._watch.begin()

    def _reopened(self, timeout_s: float) -> bool:
        """Try to open the port, if the pause before the next attempt ends within the time."""
        pause = self._next_attempt - self._monotonic()
        if self._closed.wait(min(max(pause, 0.0), timeout_s)) or pause > timeout_s:
            return False
        try:
            self._open()
        except PortError as error:
            self._failures += 1
            pause = PAUSES_S[min(self._failures, len(PAUSES_S) - 1)]
            self._next_attempt = self._monotonic() + pause
            with self._state:
                self._trouble = Problem.of(error)
        return self._port is not None

    def _wait(self, timeout_s: float) -> bytes:
        assert self._port is not None
        if not select.select([self._port.fileno()], [], [], timeout_s)[0]:
            return b""
        # Past pyserial, which would ask once more whether there is anything.
        try:
            data = piece = os.read(self._port.fileno(), READ_BYTES)
        except BlockingIOError:
            return b""  # somebody else has read it
        if not data:
            raise serial.SerialException("it is ready, but gives nothing")
        while piece and len(data) < BACKLOG_BYTES:
            # The kernel hands a backlog out in pieces; read together they are stamped together.
            piece = _more(self._port.fileno())
            data += piece
        return data

    def _ask(self) -> None:
        """Ask the device what it is, until it says so."""
        due = self._requests < REQUESTS and self._monotonic() >= self._next_request
        binary = isinstance(self._decoder, BinaryDecoder)
        if self._port is None or self._watch.info is not None or not (due and binary):
            return
        self._requests += 1
        self._next_request = self._monotonic() + REQUEST_S
        try:
            self._port.write(INFO_REQUEST)
        except serial.SerialTimeoutException:
            pass  # A device that takes nothing can still send.
        except PORT_TROUBLE as error:
            self._lose(error)

    def _lose(self, error: Exception) -> None:
        reported = f"lost ({error}); plug it in again, it is then opened by itself"
        self._release(self._reported(Code.PORT_LOST, reported))

    def _reported(self, code: str, message: str) -> Problem:
        return Problem(code, f"serial port {self._name}: {message}")

    def _release(self, trouble: Problem) -> None:
        with self._state:
            port, self._port = self._port, None
            self._trouble = trouble
            self._next_attempt = self._monotonic() + PAUSES_S[0]
        if port is not None:
            port.close()


def _more(line: int) -> bytes:
    """What else there is already; that the line has gone is found at the next reading."""
    try:
        return os.read(line, READ_BYTES)
    except OSError:
        return b""
