"""From a device's channels to the shoe's cells: names and volts."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from shoecal_ros.serial.errors import ChannelError
from shoecal_ros.serial.frame import ChannelStatus, Frame

MAX_BITS = 32


class Encoding(Enum):
    """How the device writes a converter's count as a number."""

    SIGNED = "signed"
    OFFSET_BINARY = "offset_binary"
    TWOS_COMPLEMENT = "twos_complement"


@dataclass(frozen=True, slots=True)
class Converter:
    """An analogue-digital converter.

    Attributes:
        volts_per_count: [V] (or the shoe's own unit), positive.
        bits: width; the ends of the range are -2^(bits-1) and 2^(bits-1) - 1 counts.
        encoding: offset binary is the count plus 2^(bits-1); two's complement is the count
            modulo 2^bits, as firmware prints it that does not extend the sign.
    """

    volts_per_count: float
    bits: int = 24
    encoding: Encoding = Encoding.SIGNED

    def __post_init__(self) -> None:
        if not 0.0 < self.volts_per_count < math.inf:
            raise ChannelError(f"volts_per_count {self.volts_per_count} must be above 0")
        if not 1 <= self.bits <= MAX_BITS:
            raise ChannelError(f"converter of {self.bits} bits; use 1 to {MAX_BITS}")

    @property
    def lowest(self) -> int:
        """Least count."""
        return -(1 << (self.bits - 1))

    @property
    def highest(self) -> int:
        """Greatest count."""
        return (1 << (self.bits - 1)) - 1

    def signed(self, number: float) -> float:
        """Signed count of a number the device wrote."""
        if self.encoding is Encoding.OFFSET_BINARY:
            return number + self.lowest
        if self.encoding is Encoding.TWOS_COMPLEMENT and number > self.highest:
            return number + 2 * self.lowest
        return number


@dataclass(frozen=True, slots=True)
class DeviceChannel:
    """One channel of the device.

    Attributes:
        index: number the device gives it (in text lines: the column, from 0).
        cell: name of the cell wired to it, for example `left/front_left`.
        converter: of this channel.
    """

    index: int
    cell: str
    converter: Converter


@dataclass(frozen=True, slots=True)
class CellReadings:
    """One frame in terms of cells; only the cells the frame carries.

    Attributes:
        cell: names.
        voltage: [V] (or the shoe's own unit), NaN where the cell gave none.
        status: one number a cell, see `ChannelStatus`.
    """

    cell: tuple[str, ...]
    voltage: tuple[float, ...]
    status: tuple[int, ...]


class ChannelMap:
    """Names and scales the channels of frames; counts the ones without a name."""

    def __init__(self, channels: Iterable[DeviceChannel]) -> None:
        """Raises ChannelError where two channels share an index or a cell."""
        listed = list(channels)
        self._channels = {channel.index: channel for channel in listed}
        if not len(listed) == len(self._channels) == len({channel.cell for channel in listed}):
            raise ChannelError("two channels share an index or a cell; give each its own")
        self._unseen = dict.fromkeys(channel.cell for channel in self._channels.values())
        self._unknown: Counter[int] = Counter()

    @property
    def unknown(self) -> dict[int, int]:
        """Channel indices without a name -> how often they came."""
        return dict(sorted(self._unknown.copy().items()))

    @property
    def unseen(self) -> tuple[str, ...]:
        """Cells no frame has carried so far."""
        return tuple(self._unseen)

    def readings(self, frame: Frame) -> CellReadings:
        """Voltages of a frame's named channels."""
        cells, volts, statuses = [], [], []
        for index, status, number in zip(frame.index, frame.status, frame.counts, strict=True):
            channel = self._channels.get(index)
            if channel is None:
                self._unknown[index] += 1
                continue
            count = channel.converter.signed(number)
            gone = status == ChannelStatus.NO_DATA
            cells.append(channel.cell)
            volts.append(math.nan if gone else count * channel.converter.volts_per_count)
            statuses.append(_status(status, count, channel.converter))
        if self._unseen:
            for cell in cells:
                self._unseen.pop(cell, None)
        return CellReadings(tuple(cells), tuple(volts), tuple(statuses))


def _status(sent: int, count: float, converter: Converter) -> int:
    """Status of a reading: what the device said, or what the count shows."""
    if sent > ChannelStatus.FAULT:
        return int(ChannelStatus.FAULT)
    if sent == ChannelStatus.GOOD and not converter.lowest < count < converter.highest:
        return int(ChannelStatus.SATURATED)
    return sent
