"""A device that is not there: real bytes over a pseudo-terminal, faults included."""

from __future__ import annotations

import hashlib
import math
import os
import select
import socket
import tempfile
import tty
from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_ros.serial.channel_map import Converter
from shoecal_ros.serial.errors import DeviceError
from shoecal_ros.serial.frame import ChannelStatus, Frame, Info
from shoecal_ros.serial.protocol import INFO_REQUEST, encode_frame, encode_info

PATIENCE_S = 0.05
"""How long a full buffer is waited for before bytes are dropped."""


def convert(volts: FloatArray, converter: Converter) -> tuple[IntArray, NDArray[np.uint8]]:
    """What an analogue-digital converter makes of voltages (..., n) [V].

    Returns:
        Counts, rounded and clipped to the range, and statuses: SATURATED at the ends of the
        range, NO_DATA (count 0) where the voltage is NaN.
    """
    gone = np.isnan(volts)
    exact = np.where(gone, 0.0, volts) / converter.volts_per_count
    counts = np.clip(np.rint(exact), converter.lowest, converter.highest).astype(np.int64)
    status = np.full(volts.shape, ChannelStatus.GOOD, dtype=np.uint8)
    status[(counts == converter.lowest) | (counts == converter.highest)] = ChannelStatus.SATURATED
    status[gone] = ChannelStatus.NO_DATA
    return counts, status


class SimulatedDevice:
    """The device's end of a serial line; `link` is the port to give to the driver.

    Attributes:
        sent: frames put on the line.
        dropped: frames that found the line full, or no reader at its other end.
    """

    def __init__(self, link: Path, info: Info, *, patience_s: float = PATIENCE_S) -> None:
        """A device that is plugged in.

        Args:
            link: path of a symbolic link to make; it stays the same over unplugging.
            info: what the device says of itself, when somebody opens the port and on request.
            patience_s: how long a full line is waited for before a frame is dropped [s].

        Raises:
            DeviceError: when the link cannot be made, is another device's, or something else stands
                in its place.
        """
        self._claim = _claimed(link)
        self.sent = self.dropped = 0
        self._link, self._info, self._patience_s = link, info, patience_s
        self._line: int | None = None
        self._poll = select.poll()
        self._begin()
        self._lose = 0
        self._flips: list[int] = []
        try:
            self.plug()
        except DeviceError:
            self._claim.close()
            raise

    def plug(self) -> None:
        """Appear as a new pseudo-terminal behind the link."""
        if self._line is not None:
            return
        line, port = os.openpty()
        try:
            tty.setraw(port)
            self._point_link(os.ttyname(port))
        except OSError as error:
            os.close(line)
            raise DeviceError(
                f"{self._link}: cannot be made a link to the simulated device "
                f"({error.strerror}); check the folder and what stands there"
            ) from error
        finally:
            # With this end closed, the line shows whether another process has it open.
            os.close(port)
        os.set_blocking(line, False)
        self._poll.register(line, select.POLLOUT)
        self._line = line
        self._begin()

    def unplug(self) -> None:
        """Vanish: the reader gets an error, and the link is gone."""
        if self._line is None:
            return
        self._link.unlink(missing_ok=True)
        self._poll.unregister(self._line)
        os.close(self._line)
        self._line = None

    def send(
        self,
        sequence: int,
        time_us: int,
        counts: Iterable[int],
        status: Iterable[int],
        *,
        temperature: float = math.nan,
    ) -> bool:
        """Send one frame, channels numbered from 0; answer the driver if it has asked.

        Args:
            sequence: counts every frame, modulo 2^32.
            time_us: device clock at sampling [us].
            counts: of the converter, one a channel.
            status: one number a channel, see `ChannelStatus`.
            temperature: [degC], NaN where there is no sensor.

        Returns:
            Whether the frame went out whole.
        """
        self._answer()
        numbers = tuple(int(count) for count in counts)
        frame = Frame(
            sequence=sequence,
            device_time_us=time_us,
            index=tuple(range(len(numbers))),
            status=tuple(int(value) for value in status),
            counts=numbers,
            temperature=None if math.isnan(temperature) else temperature,
        )
        data = encode_frame(frame)
        if self._lose:
            self._lose -= 1
            return False
        if self._flips:
            damaged = bytearray(data)
            for place in self._flips:
                damaged[place % len(data)] ^= 0x10
            data, self._flips = bytes(damaged), []
        whole = self.send_bytes(data)
        self.sent += whole
        self.dropped += not whole
        return whole

    def send_bytes(self, data: bytes) -> bool:
        """Put raw bytes on the line, or none of them where it stays full or has no reader.

        What was begun is finished first, so a full line never cuts a frame.
        """
        if self._line is None or not self._listened():
            return False
        if not self._flush(self._line):
            return False
        self._unsent = data
        self._flush(self._line)
        return True

    def lose_frames(self, count: int) -> None:
        """Fault: the next frames are never sent."""
        self._lose += count

    def corrupt_next(self, *places: int) -> None:
        """Fault: a bit of the next frame flips at each of these bytes."""
        self._flips += places

    def close(self) -> None:
        """Unplug for good."""
        self.unplug()
        self._claim.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _begin(self) -> None:
        self._unsent = self._heard = b""
        self._listener = self._stuck = False

    def _listened(self) -> bool:
        """Whether a process has the port open; a new one is sent what this is."""
        if any(state & select.POLLHUP for _, state in self._poll.poll(0)):
            self._begin()
        elif not self._listener:
            self._listener = True
            self._unsent = encode_info(self._info)
        return self._listener

    def _flush(self, line: int) -> bool:
        """Write what is left of the last bytes; a line that does not move is waited for once."""
        while self._unsent:
            try:
                self._unsent = self._unsent[os.write(line, self._unsent) :]
                self._stuck = False
            except BlockingIOError:
                if self._stuck:
                    return False
                self._stuck = not self._poll.poll(self._patience_s * 1000)
        return True

    def _answer(self) -> None:
        if self._line is None or not self._listened():
            return
        try:
            self._heard = (self._heard + os.read(self._line, 1024))[-2 * len(INFO_REQUEST) :]
        except OSError:
            return  # Nothing heard, or the listener has just gone.
        if INFO_REQUEST in self._heard:
            self._heard = b""
            self.send_bytes(encode_info(self._info))

    def _point_link(self, target: str) -> None:
        if self._link.exists() and not self._link.is_symlink():
            raise FileExistsError(0, "a file of this name stands there")
        with tempfile.TemporaryDirectory(dir=self._link.parent) as folder:
            fresh = Path(folder) / "link"
            fresh.symlink_to(target)
            fresh.replace(self._link)


def _claimed(link: Path) -> socket.socket:
    """Keeps a link for one device: a bound socket, which the kernel closes however a process ends.

    Raises:
        DeviceError: when another device has it.
    """
    place = Path(os.path.realpath(link.parent)) / link.name
    claim = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        claim.bind(f"\0shoecal {hashlib.sha256(bytes(place)).hexdigest()}")
    except OSError as error:
        claim.close()
        raise DeviceError(
            f"{link}: is the port of another simulator that runs; end that one, or choose another "
            "'port' (demo.launch.py: another namespace)"
        ) from error
    return claim
