"""The binary protocol, version 1, both ways; docs/reference/protocol.md is its definition."""

from __future__ import annotations

import struct
from zlib import crc32

from shoecal_ros.serial.cobs import MAX_PACKET, stuff, unstuff
from shoecal_ros.serial.continuity import Continuity
from shoecal_ros.serial.decoder import Decoder
from shoecal_ros.serial.errors import FrameError
from shoecal_ros.serial.frame import (
    MAX_CHANNELS,
    Event,
    FaultKind,
    Frame,
    FrameFault,
    Info,
)

VERSION = 1
TYPE_FRAME = 1
TYPE_INFO = 2
TYPE_INFO_REQUEST = 3

DELIMITER = b"\0"
NO_TEMPERATURE = -(2**15)
MAX_FIRMWARE_BYTES = 64

_CRC = struct.Struct("<I")
_INFO = struct.Struct("<BBBI")
_FRAME_HEAD = "<BBIQhB"
_FRAMES = tuple(struct.Struct(_FRAME_HEAD + "BBi" * n) for n in range(MAX_CHANNELS + 1))
_MIN_PACKET = 2 + _CRC.size


def encode_frame(frame: Frame) -> bytes:
    """Bytes of one frame, delimiter included.

    Raises:
        FrameError: for a frame without device time, or a value beyond its field.
    """
    if frame.device_time_us is None:
        raise FrameError("a binary frame needs the device time")
    celsius = frame.temperature
    hundredths = NO_TEMPERATURE if celsius is None else round(celsius * 100)
    channels = [
        value
        for channel in zip(frame.index, frame.status, frame.counts, strict=True)
        for value in channel
    ]
    try:
        packet = _FRAMES[len(frame.index)].pack(
            VERSION,
            TYPE_FRAME,
            frame.sequence,
            frame.device_time_us,
            hundredths,
            len(frame.index),
            *channels,
        )
    except struct.error as error:
        raise FrameError(f"frame does not fit its fields ({error})") from error
    return _seal(packet)


def encode_info(info: Info) -> bytes:
    """Bytes of the device's answer to `INFO_REQUEST`, delimiter included."""
    name = info.firmware.encode()
    if len(name) > MAX_FIRMWARE_BYTES:
        raise FrameError(f"firmware name longer than {MAX_FIRMWARE_BYTES} bytes; shorten it")
    try:
        head = _INFO.pack(info.protocol_version, TYPE_INFO, info.channels, round(info.rate * 1000))
    except struct.error as error:
        raise FrameError(f"info does not fit its fields ({error})") from error
    return _seal(head + name)


def _seal(packet: bytes) -> bytes:
    return stuff(packet + _CRC.pack(crc32(packet))) + DELIMITER


INFO_REQUEST = DELIMITER + _seal(bytes((VERSION, TYPE_INFO_REQUEST)))
"""What the driver sends to ask for an INFO; constant, so that firmware may compare bytes."""


class BinaryDecoder(Decoder):
    """Of stuffed packets with a checksum."""

    longest = MAX_PACKET + 1
    sealed = True

    def __init__(self) -> None:
        super().__init__(Continuity())

    def split(self, data: bytes) -> list[bytes]:
        """At zeros, which stuffed packets have none of."""
        return data.split(DELIMITER)

    def read(self, piece: bytes) -> Event:
        """One packet as it stood between two delimiters."""
        packet = unstuff(piece)
        if packet is None or len(packet) < _MIN_PACKET:
            return FrameFault(FaultKind.BAD_LENGTH, f"{len(piece)} bytes are no stuffed packet")
        if crc32(packet[: -_CRC.size]) != _CRC.unpack(packet[-_CRC.size :])[0]:
            return FrameFault(FaultKind.BAD_CHECKSUM, f"checksum wrong in {len(packet)} bytes")
        version, kind = packet[0], packet[1]
        if version != VERSION:
            return FrameFault(
                FaultKind.FOREIGN_VERSION,
                f"the device speaks protocol version {version}, this driver {VERSION}; "
                f"update {'the driver' if version > VERSION else 'its firmware'}",
            )
        body = packet[: -_CRC.size]
        if kind == TYPE_FRAME:
            return _decode_frame(body)
        if kind == TYPE_INFO:
            return _decode_info(body)
        return FrameFault(FaultKind.UNKNOWN_TYPE, f"frame type {kind} is not known here")


def _decode_frame(body: bytes) -> Event:
    head = _FRAMES[0].size
    n = body[head - 1] if len(body) >= head else 0
    if not 0 < n <= MAX_CHANNELS or len(body) != _FRAMES[n].size:
        return FrameFault(FaultKind.BAD_LENGTH, f"{len(body)} bytes do not make {n} channels")
    _, _, sequence, time_us, hundredths, _, *channels = _FRAMES[n].unpack(body)
    try:
        return Frame(
            sequence=sequence,
            device_time_us=time_us,
            index=tuple(channels[0::3]),
            status=tuple(channels[1::3]),
            counts=tuple(channels[2::3]),
            temperature=None if hundredths == NO_TEMPERATURE else hundredths / 100,
        )
    except FrameError as error:
        return FrameFault(FaultKind.BAD_CONTENT, str(error))


def _decode_info(body: bytes) -> Event:
    if not _INFO.size <= len(body) <= _INFO.size + MAX_FIRMWARE_BYTES:
        return FrameFault(FaultKind.BAD_LENGTH, f"info of {len(body)} bytes")
    version, _, channels, millihertz = _INFO.unpack_from(body)
    try:
        name = body[_INFO.size :].decode()
    except UnicodeDecodeError:
        return FrameFault(FaultKind.BAD_CONTENT, "firmware name is not UTF-8")
    return Info(name, version, channels, millihertz / 1000)
