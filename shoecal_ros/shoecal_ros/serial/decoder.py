"""From bytes to events, whatever the protocol: pieces between delimiters, one read at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod

from shoecal_ros.serial.continuity import Continuity
from shoecal_ros.serial.frame import Event, FaultKind, Frame, FrameFault, LinkCounts


class Decoder(ABC):
    """Turns bytes into events, however the stream is cut; never raises on any bytes.

    It holds at most one piece, and passes over a longer one up to its end.
    """

    longest: int
    """Bytes of a piece at most."""
    sealed: bool
    """Whether a piece proves by itself that it is whole. One that does not may be the end of a
    number where its beginning was not seen."""

    def __init__(self, continuity: Continuity) -> None:
        self._counts = LinkCounts()
        self._continuity = continuity
        self._partial = b""
        self._overlong = False
        self._begun = False

    @abstractmethod
    def split(self, data: bytes) -> list[bytes]:
        """What stands between delimiters; what follows the last of them comes last."""

    @abstractmethod
    def read(self, piece: bytes) -> Event | None:
        """What a piece says; None for one without content."""

    @property
    def counts(self) -> LinkCounts:
        """Totals so far."""
        return self._counts

    @property
    def pending(self) -> int:
        """Bytes that wait for the rest of their piece; bounded whatever comes."""
        return len(self._partial)

    def resume(self) -> None:
        """Forget a half-read piece: the next bytes start anywhere in the stream."""
        self._counts.skipped_bytes += len(self._partial)
        self._partial = b""
        self._overlong = self._begun = False

    def feed(self, data: bytes) -> list[Event]:
        """Events that these bytes complete."""
        self._counts.bytes += len(data)
        *complete, rest = self.split(data)
        events: list[Event] = []
        for part in complete:
            self._extend(part)
            self._finish(events)
        self._extend(rest)
        for event in events:
            self._counts.add(event)
        return events

    def _extend(self, part: bytes) -> None:
        if self._overlong or len(self._partial) + len(part) > self.longest:
            self._counts.skipped_bytes += len(self._partial) + len(part)
            self._partial = b""
            self._overlong = True
        else:
            self._partial += part

    def _finish(self, events: list[Event]) -> None:
        """Read what stands between two delimiters."""
        piece, self._partial = self._partial, b""
        overlong, self._overlong = self._overlong, False
        begun, self._begun = self._begun, True
        event: Event | None = None
        if overlong:
            event = FrameFault(FaultKind.BAD_LENGTH, f"more than {self.longest} bytes and no end")
        elif begun or self.sealed:
            event = self.read(piece) if piece else None
        else:
            self._counts.skipped_bytes += len(piece)
        if event is None:
            return
        if isinstance(event, FrameFault):
            self._counts.skipped_bytes += len(piece)
            # The first bytes after opening are mostly the end of a piece: not a fault.
            if not begun:
                return
        elif isinstance(event, Frame):
            events += self._continuity.check(event)
        events.append(event)
