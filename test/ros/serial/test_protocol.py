from __future__ import annotations

import ctypes
import random
import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.serial.helpers import INFO, any_frame, frame, frames, kinds, sealed
from shoecal_ros.serial.cobs import MAX_PACKET, stuff
from shoecal_ros.serial.errors import FrameError
from shoecal_ros.serial.frame import Event, FaultKind, Frame, Info
from shoecal_ros.serial.protocol import (
    INFO_REQUEST,
    BinaryDecoder,
    encode_frame,
    encode_info,
)

DOCUMENT = (Path(__file__).parents[3] / "docs/reference/protocol.md").read_text()
EXAMPLE = Frame(258, 1_000_000, (0, 1), (0, 1), (-5, 8388607), 25.25)


def block(kind: str) -> str:
    """A fenced block of the document."""
    match = re.search(rf"```{kind}\n(.*?)```", DOCUMENT, re.DOTALL)
    assert match is not None
    return match.group(1)


def in_pieces(decoder: BinaryDecoder, data: bytes, cuts: list[int]) -> list[Event]:
    places = sorted(cut % (len(data) + 1) for cut in cuts)
    events = []
    for start, end in zip([0, *places], [*places, len(data)], strict=True):
        events += decoder.feed(data[start:end])
    return events


def test_example_of_the_document() -> None:
    wire = bytes.fromhex(block("hex wire"))
    assert encode_frame(EXAMPLE) == wire
    assert stuff(bytes.fromhex(block("hex packet"))) + b"\0" == wire
    assert BinaryDecoder().feed(wire) == [EXAMPLE]
    assert bytes.fromhex(block("hex info-request")) == INFO_REQUEST


@pytest.mark.skipif(shutil.which("cc") is None, reason="compiles the document's encoder")
def test_encoder_of_the_document(tmp_path: Path) -> None:
    source, library = tmp_path / "encode.c", tmp_path / "encode.so"
    source.write_text(block("c"))
    options = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC"]
    subprocess.run(["cc", *options, "-o", library, source], check=True)
    encode = ctypes.CDLL(str(library)).encode

    @given(any_frame())
    def agrees(sent: Frame) -> None:
        n = len(sent.index)
        expected = encode_frame(sent)
        out = ctypes.create_string_buffer(len(expected))
        celsius = sent.temperature
        length = encode(
            out,
            ctypes.c_uint32(sent.sequence),
            ctypes.c_uint64(sent.device_time_us or 0),
            ctypes.c_int16(-(2**15) if celsius is None else round(celsius * 100)),
            ctypes.c_int(n),
            (ctypes.c_uint8 * n)(*sent.index),
            (ctypes.c_uint8 * n)(*sent.status),
            (ctypes.c_int32 * n)(*map(int, sent.counts)),
        )
        assert length == len(expected) == 23 + 6 * n
        assert out.raw == expected

    agrees()


@given(any_frame())
def test_frame_round_trip(sent: Frame) -> None:
    assert BinaryDecoder().feed(encode_frame(sent)) == [sent]


@given(
    st.builds(
        Info,
        firmware=st.text(st.characters(exclude_categories=["Cs"]), max_size=16),
        protocol_version=st.just(1),
        channels=st.integers(0, 255),
        rate=st.integers(0, 2**32 - 1).map(lambda millihertz: millihertz / 1000),
    )
)
def test_info_round_trip(info: Info) -> None:
    assert BinaryDecoder().feed(encode_info(info)) == [info]


@given(st.lists(any_frame(), max_size=5), st.lists(st.integers(0), max_size=8))
def test_cuts_change_nothing(sent: list[Frame], cuts: list[int]) -> None:
    data = b"".join(map(encode_frame, sent))
    whole, cut = BinaryDecoder(), BinaryDecoder()
    assert in_pieces(cut, data, cuts) == whole.feed(data)
    assert cut.counts == whole.counts
    assert frames(whole.feed(b"")) == []


@given(st.lists(any_frame(), max_size=3), st.binary(max_size=600), any_frame())
def test_after_garbage_the_next_frame_is_read(
    before: list[Frame], garbage: bytes, after: Frame
) -> None:
    decoder = BinaryDecoder()
    data = b"".join(map(encode_frame, before)) + garbage + b"\0" + encode_frame(after)
    assert frames(decoder.feed(data)) == [*before, after]


mutations = st.lists(
    st.tuples(
        st.sampled_from(("flip", "set", "insert", "delete", "repeat")),
        st.integers(0, 10_000),
        st.integers(0, 255),
    ),
    min_size=1,
    max_size=4,
)


@given(st.lists(any_frame(), min_size=1, max_size=4), mutations)
def test_no_damaged_frame_is_accepted(
    sent: list[Frame], mutations: list[tuple[str, int, int]]
) -> None:
    data = bytearray(b"".join(map(encode_frame, sent)))
    for kind, anywhere, byte in mutations:
        place = anywhere % len(data)
        if kind == "flip":
            data[place] ^= 1 << byte % 8
        elif kind == "set":
            data[place] = byte
        elif kind == "insert":
            data.insert(place, byte)
        elif kind == "delete" and len(data) > 1:
            del data[place]
        else:
            data[place:place] = data[place : place + byte]
    decoder = BinaryDecoder()
    last = frame(7)
    got = frames(decoder.feed(bytes(data) + b"\0" + encode_frame(last)))
    assert got[-1] == last
    assert all(each in sent for each in got[:-1])


def test_a_million_random_bytes() -> None:
    rng = random.Random(1)
    decoder = BinaryDecoder()
    for _ in range(250):
        assert frames(decoder.feed(rng.randbytes(4000))) == []
        assert len(decoder._partial) <= MAX_PACKET + 1
    counts = decoder.counts
    assert counts.bytes == 1_000_000
    assert counts.faults[FaultKind.BAD_LENGTH] > 1000
    assert counts.frames == 0
    assert frames(decoder.feed(b"\0" + encode_frame(EXAMPLE))) == [EXAMPLE]


def test_an_endless_packet_is_one_fault() -> None:
    decoder = BinaryDecoder()
    decoder.feed(b"\0")
    assert decoder.feed(encode_frame(frame(0))) == [frame(0)]
    events = [event for _ in range(100) for event in decoder.feed(b"\x55" * 100)]
    assert events == []
    assert kinds(decoder.feed(b"\0")) == [FaultKind.BAD_LENGTH]
    assert decoder.counts.skipped_bytes == 10_000


def in_step() -> BinaryDecoder:
    decoder = BinaryDecoder()
    decoder.feed(encode_info(INFO))
    return decoder


def test_every_flipped_bit_is_noticed() -> None:
    data = encode_frame(EXAMPLE)
    for bit in range(8 * (len(data) - 1)):
        damaged = bytearray(data)
        damaged[bit // 8] ^= 1 << bit % 8
        decoder = in_step()
        events = decoder.feed(bytes(damaged))
        assert frames(events) == []
        assert kinds(events)


def test_cut_beginning_of_the_stream_is_no_fault() -> None:
    decoder = BinaryDecoder()
    tail = encode_frame(frame(4))[20:]
    assert decoder.feed(tail + encode_frame(frame(5))) == [frame(5)]
    assert decoder.counts.skipped_bytes == len(tail) - 1
    assert len(kinds(decoder.feed(tail))) == 1
    decoder.resume()
    assert decoder.feed(tail) == []


def test_reopening_forgets_half_a_frame() -> None:
    decoder = in_step()
    decoder.feed(encode_frame(frame(4))[:20])
    decoder.resume()
    assert decoder.feed(encode_frame(frame(5))) == [frame(5)]


def test_another_version_is_named() -> None:
    events = in_step().feed(sealed(b"\x02\x01whatever"))
    assert kinds(events) == [FaultKind.FOREIGN_VERSION]
    assert "version 2" in str(events[0])
    assert "update the driver" in str(events[0])
    assert "its firmware" in str(in_step().feed(sealed(b"\x00\x01whatever"))[0])


@pytest.mark.parametrize(
    ("packet", "kind"),
    [
        (b"\x01\x09", FaultKind.UNKNOWN_TYPE),
        (b"\x01", FaultKind.BAD_LENGTH),
        (b"\x01\x01" + bytes(15), FaultKind.BAD_LENGTH),  # no channels
        (b"\x01\x01" + bytes(14) + b"\x02" + bytes(6), FaultKind.BAD_LENGTH),
        (b"\x01\x01" + bytes(14) + b"\x02" + bytes(12), FaultKind.BAD_CONTENT),  # twice 0
        (b"\x01\x01" + bytes(14) + b"\xff" + bytes(200), FaultKind.BAD_LENGTH),
        (b"\x01\x02\x08", FaultKind.BAD_LENGTH),
        (b"\x01\x02\x08\x00\x00\x00\x00" + b"x" * 65, FaultKind.BAD_LENGTH),
        (b"\x01\x02\x08\x00\x00\x00\x00\xff", FaultKind.BAD_CONTENT),
    ],
)
def test_sealed_nonsense_is_a_fault(packet: bytes, kind: FaultKind) -> None:
    decoder = in_step()
    assert kinds(decoder.feed(sealed(packet))) == [kind]
    assert decoder.counts.faults == {kind: 1}


def test_lost_frames_are_counted_around_the_end_of_the_sequence() -> None:
    decoder = BinaryDecoder()
    numbers = [2**32 - 4, 2**32 - 3, 2**32 - 1, 0, 3]
    for time, number in enumerate(numbers):
        decoder.feed(encode_frame(frame(number, time)))
    assert decoder.counts.frames == len(numbers)
    assert decoder.counts.faults == {FaultKind.LOST_FRAMES: 3}


@pytest.mark.parametrize(
    ("sequence", "time", "lost"), [(1000, 5, 1000), (3, 2000, 3), (1002, 5, 1002), (0, 0, 0)]
)
def test_restart_is_seen_in_time_or_sequence(sequence: int, time: int, lost: int) -> None:
    """And what was lost since: a device counts from 0."""
    decoder = BinaryDecoder()
    decoder.feed(encode_frame(frame(1000, 1000)))
    events = decoder.feed(encode_frame(frame(sequence, time)))
    assert kinds(events) == [FaultKind.RESTART, FaultKind.LOST_FRAMES][: 2 if lost else 1]
    assert decoder.feed(encode_frame(frame(sequence + 1, time + 1))) == [
        frame(sequence + 1, time + 1)
    ]
    assert decoder.counts.faults[FaultKind.RESTART] == 1
    assert decoder.counts.faults[FaultKind.LOST_FRAMES] == lost


def test_a_clock_that_is_read_unevenly_is_no_restart() -> None:
    decoder = BinaryDecoder()
    hour = 3_600_000_000
    for sequence, time in ((360_000, hour), (360_001, hour - 1), (360_002, hour + 9_999)):
        sent = frame(sequence, time)
        assert decoder.feed(encode_frame(sent)) == [sent]
    assert not decoder.counts.faults
    events = decoder.feed(encode_frame(frame(360_003, 30_000)))
    assert kinds(events) == [FaultKind.RESTART, FaultKind.LOST_FRAMES]


def test_sequence_that_stands_still_is_named() -> None:
    decoder = BinaryDecoder()
    decoder.feed(encode_frame(frame(1, 1)))
    assert kinds(decoder.feed(encode_frame(frame(1, 2)))) == [FaultKind.REPEATED_SEQUENCE]


@pytest.mark.parametrize(
    "change",
    [
        {"device_time_us": None},
        {"temperature": 400.0},
        {"counts": (0, 2**31)},
        {"counts": (0, 0.5)},
        {"status": (0, 256)},
        {"index": (0, 256)},
    ],
)
def test_what_does_not_fit_is_refused(change: dict[str, object]) -> None:
    with pytest.raises(FrameError):
        encode_frame(replace(EXAMPLE, **change))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "change",
    [
        {"sequence": 2**32},
        {"sequence": -1},
        {"device_time_us": 2**64},
        {"index": (1, 1)},
        {"status": (0,)},
        {"index": (), "status": (), "counts": ()},
        {"index": tuple(range(33)), "status": (0,) * 33, "counts": (0,) * 33},
    ],
)
def test_frame_that_cannot_exist_is_refused(change: dict[str, object]) -> None:
    with pytest.raises(FrameError):
        replace(EXAMPLE, **change)  # type: ignore[arg-type]


@pytest.mark.parametrize("change", [{"firmware": "x" * 65}, {"channels": 256}, {"rate": -1.0}])
def test_info_that_does_not_fit_is_refused(change: dict[str, object]) -> None:
    with pytest.raises(FrameError):
        encode_info(replace(INFO, **change))  # type: ignore[arg-type]
