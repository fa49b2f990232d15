"""The firmware's packets, byte for byte against the driver's own encoder."""

from __future__ import annotations

import ctypes
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ros.firmware.board import FIRMWARE
from ros.serial.helpers import any_frame, frames
from shoecal_ros.serial.frame import Frame, Info
from shoecal_ros.serial.protocol import INFO_REQUEST, BinaryDecoder, encode_frame, encode_info


class ReadingStruct(ctypes.Structure):
    _fields_ = (
        ("index", ctypes.c_uint8),
        ("status", ctypes.c_uint8),
        ("counts", ctypes.c_int32),
    )


@pytest.fixture(scope="module")
def firmware(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """Its portable half as a library."""
    library = tmp_path_factory.mktemp("firmware") / "packets.so"
    sources: list[Path] = [FIRMWARE / "src/packet.c", FIRMWARE / "src/request.c"]
    subprocess.run(
        [os.environ.get("CC", "cc"), "-std=c99", "-shared", "-fPIC", *sources, "-o", library],
        check=True,
    )
    loaded = ctypes.CDLL(str(library))
    loaded.packet_frame.restype = loaded.packet_info.restype = ctypes.c_uint8
    loaded.request_heard.restype = ctypes.c_bool
    return loaded


@pytest.fixture(scope="module")
def heard(firmware: ctypes.CDLL) -> Callable[[bytes], int]:
    """How many info requests the firmware hears in some bytes."""
    return lambda data: sum(firmware.request_heard(ctypes.c_uint8(byte)) for byte in data)


def c_frame(firmware: ctypes.CDLL, frame: Frame) -> bytes:
    count = len(frame.index)
    rows = zip(frame.index, frame.status, frame.counts, strict=True)
    readings = (ReadingStruct * count)(*(ReadingStruct(*row) for row in rows))
    out = (ctypes.c_uint8 * 256)()
    degrees = -(2**15) if frame.temperature is None else round(frame.temperature * 100)
    length = firmware.packet_frame(
        out,
        ctypes.c_uint32(frame.sequence),
        ctypes.c_uint64(frame.device_time_us or 0),
        ctypes.c_int16(degrees),
        readings,
        ctypes.c_uint8(count),
    )
    return bytes(out[:length])


@given(frame=any_frame())
@settings(max_examples=300, deadline=None)
def test_frames(firmware: ctypes.CDLL, frame: Frame) -> None:
    wire = c_frame(firmware, frame)
    assert wire == encode_frame(frame)
    assert frames(BinaryDecoder().feed(wire)) == [frame]


@given(name=st.text("abc-. 019", max_size=64), channels=st.integers(0, 255))
def test_infos(firmware: ctypes.CDLL, name: str, channels: int) -> None:
    out = (ctypes.c_uint8 * 256)()
    length = firmware.packet_info(
        out, ctypes.c_uint8(channels), ctypes.c_uint32(80_000), name.encode()
    )
    assert bytes(out[:length]) == encode_info(Info(name, 1, channels, 80.0))


@given(
    parts=st.lists(
        st.sampled_from([INFO_REQUEST, INFO_REQUEST[:-1], INFO_REQUEST[1:], b"\0", b"\7\1"]),
        max_size=12,
    )
)
def test_requests_are_heard_in_any_noise(heard: Callable[[bytes], int], parts: list[bytes]) -> None:
    """Each is heard where its bytes stand, and nowhere else; requests may share a delimiter."""
    heard(b"\1\0")  # at a delimiter
    data = b"".join(parts)
    core = INFO_REQUEST.strip(b"\0")
    pieces = (b"\0" + data).split(b"\0")
    assert heard(data) == sum(piece == core for piece in pieces[1:-1])
