"""What comes out of a stream of bytes, whatever its protocol: frames, device facts and faults."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from enum import Enum, IntEnum

from shoecal_ros.serial.errors import FrameError

MAX_CHANNELS = 32
SEQUENCE_MODULUS = 2**32
DEVICE_TIME_MODULUS = 2**64


class ChannelStatus(IntEnum):
    """Status of one channel; the same numbers as in shoecal_msgs/msg/ShoeVoltages."""

    GOOD = 0
    SATURATED = 1
    NO_DATA = 2
    FAULT = 3


@dataclass(frozen=True, slots=True)
class Frame:
    """One sampling of the device's channels.

    Attributes:
        sequence: counts every frame, modulo 2^32; made up by the decoder of text lines.
        device_time_us: device clock at sampling [us], None where the device gives none: then
            only the time of receipt is known.
        index: channel numbers of the device, in the order sent.
        status: one number a channel, see `ChannelStatus`; others count as FAULT.
        counts: converter counts, whole numbers; a text line may carry any number.
        temperature: [degC], None where there is no sensor.
    """

    sequence: int
    device_time_us: int | None
    index: tuple[int, ...]
    status: tuple[int, ...]
    counts: tuple[float, ...]
    temperature: float | None = None

    def __post_init__(self) -> None:
        n = len(self.index)
        if not 0 < n <= MAX_CHANNELS:
            raise FrameError(f"frame with {n} channels; use 1 to {MAX_CHANNELS}")
        if len(self.status) != n or len(self.counts) != n:
            raise FrameError(
                f"frame with {n} channels, {len(self.status)} statuses and {len(self.counts)} "
                "counts; give one of each a channel"
            )
        if len(set(self.index)) != n:
            raise FrameError(f"frame with a channel twice: {self.index}; number them differently")
        if not 0 <= self.sequence < SEQUENCE_MODULUS:
            raise FrameError(f"sequence {self.sequence} is not within 0 to 2^32 - 1")
        time = self.device_time_us
        if time is not None and not 0 <= time < DEVICE_TIME_MODULUS:
            raise FrameError(f"device time {time} us is not within 0 to 2^64 - 1")


@dataclass(frozen=True, slots=True)
class Info:
    """What the device says of itself.

    Attributes:
        firmware: name and version of the firmware.
        protocol_version: it speaks.
        channels: how many it has.
        rate: nominal frames per second [Hz], 0 where it has none.
    """

    firmware: str
    protocol_version: int
    channels: int
    rate: float


class FaultKind(Enum):
    """What can be wrong with a stream; the value is the name used in diagnostics."""

    BAD_CHECKSUM = "bad checksum"
    BAD_LENGTH = "bad length"
    BAD_CONTENT = "bad content"
    FOREIGN_VERSION = "foreign version"
    UNKNOWN_TYPE = "unknown type"
    CHATTER = "chatter"
    LOST_FRAMES = "lost frames"
    REPEATED_SEQUENCE = "repeated sequence"
    RESTART = "device restart"


@dataclass(frozen=True, slots=True)
class FrameFault:
    """Something wrong at one place of the stream.

    Attributes:
        kind: what.
        count: how many times, for example frames lost.
        text: one line for the log.
    """

    kind: FaultKind
    text: str
    count: int = 1


Event = Frame | Info | FrameFault


@dataclass
class LinkCounts:
    """Totals of a decoder since it was made."""

    bytes: int = 0
    skipped_bytes: int = 0
    frames: int = 0
    faults: Counter[FaultKind] = field(default_factory=Counter)

    def add(self, event: Event) -> None:
        """Count one event."""
        if isinstance(event, Frame):
            self.frames += 1
        elif isinstance(event, FrameFault):
            self.faults[event.kind] += event.count

    def copy(self) -> LinkCounts:
        """Totals as they are now."""
        return LinkCounts(self.bytes, self.skipped_bytes, self.frames, self.faults.copy())
