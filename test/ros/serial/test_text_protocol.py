from __future__ import annotations

import itertools
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.serial.helpers import frames, kinds
from shoecal_ros.serial.frame import FaultKind, Frame
from shoecal_ros.serial.text_protocol import MAX_LINE, TextDecoder, TextTime


def started(time: TextTime = TextTime.NONE, columns: int | None = None) -> TextDecoder:
    decoder = TextDecoder(time, columns)
    decoder.feed(b"\n")
    return decoder


@pytest.mark.parametrize(
    "line",
    [
        "1,-22,3.5",
        "1;-22;3.5",
        "1 -22 3.5",
        "1\t-22\t3.5",
        " 1 ,  -22;\t+3.5  ",
        "1,-22,3.5,",
        "fl=1,fr=-22,rl=3.5",
        "fl: 1, fr: -22, rl: 3.5",
        "left/fl:1 left/fr:-22 left/rl:3.5",
        "a[0] = 1\ta[1] = -22\t35e-1",
    ],
)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_that_mean_the_same(line: str, end: str) -> None:
    assert started().feed((line + end).encode()) == [
        Frame(0, None, (0, 1, 2), (0, 0, 0), (1.0, -22.0, 3.5))
    ]


@pytest.mark.parametrize(
    "line",
    [
        "Ready.",
        "HX711 found",
        "Tare done: offset 8388607 counts",
        "12:34:56 1 2",
        "1,,2",
        "0x10,0x20",
        "--1,2",
        "1.2.3",
        "\x00\xff\x80",
        "fl=,fr=2",
        "1,2 # comment",
    ],
)
def test_chatter_is_skipped_and_counted(line: str) -> None:
    decoder = started()
    chatter = line.encode("latin-1") + b"\n"
    events = decoder.feed(b"1,2\n" + chatter + b"3,4\n")
    assert [frame.counts for frame in frames(events)] == [(1, 2), (3, 4)]
    assert [frame.sequence for frame in frames(events)] == [0, 1]
    assert decoder.counts.faults == {FaultKind.CHATTER: 1}
    assert decoder.counts.skipped_bytes == len(chatter) - 1


def test_first_line_may_be_cut_and_is_not_taken() -> None:
    decoder = TextDecoder()
    assert [frame.counts for frame in frames(decoder.feed(b"34,5\r\n12,5\r\n"))] == [(12, 5)]
    assert decoder.counts.faults == {}
    decoder.feed(b"77,")
    decoder.resume()
    assert frames(decoder.feed(b"8,9\n")) == []


def test_other_numbers_of_columns_are_left_out() -> None:
    decoder = started(columns=2)
    events = decoder.feed(b"1,2\n1,2,3\n1\n3,4\n")
    assert [frame.counts for frame in frames(events)] == [(1, 2), (3, 4)]
    assert decoder.counts.faults == {FaultKind.BAD_LENGTH: 2}
    assert "3 values, expected 2" in str(events[1])


def test_more_columns_than_a_frame_can_have() -> None:
    assert kinds(started().feed(b"1," * 33 + b"\n")) == [FaultKind.BAD_CONTENT]


def test_what_the_converter_did_not_give() -> None:
    (frame,) = frames(started().feed(b"1,nan,fl=NaN,-inf,ovf,1e999\n"))
    assert frame.status == (0, 2, 2, 2, 2, 2)
    assert frame.counts == (1, 0, 0, 0, 0, 0)


@pytest.mark.parametrize(
    ("time", "line", "microseconds"),
    [
        (TextTime.MILLISECONDS, b"1234,1,2\n", 1_234_000),
        (TextTime.MILLISECONDS, b"t=1234.5 a=1 b=2\n", 1_234_500),
        (TextTime.MICROSECONDS, b"1234,1,2\n", 1234),
    ],
)
def test_device_time(time: TextTime, line: bytes, microseconds: int) -> None:
    (frame,) = frames(started(time, 2).feed(line))
    assert frame.device_time_us == microseconds
    assert frame.counts == (1, 2)


@pytest.mark.parametrize("line", [b"-1e10,1\n", b"nan,1\n", b"1e300,1\n"])
def test_what_is_no_device_time(line: bytes) -> None:
    assert kinds(started(TextTime.MILLISECONDS).feed(line)) == [FaultKind.BAD_CONTENT]


@pytest.mark.parametrize("time", [TextTime.MILLISECONDS, TextTime.MICROSECONDS])
@pytest.mark.parametrize("bits", [16, 24, 31, 32])
@pytest.mark.parametrize("signed", [False, True])
def test_device_time_goes_on_where_its_counter_wraps(
    time: TextTime, bits: int, signed: bool
) -> None:
    """`micros()` in however many bits, printed as a number with a sign or without."""
    decoder, least = started(time), -(2 ** (bits - 1)) if signed else 0
    ticks = [(2**bits - 20 + 10 * step - least) % 2**bits + least for step in range(6)]
    ticks += [tick + 2 ** (bits - 1) - 60 for tick in ticks[2:]] if signed else []
    ticks += [-(2 ** (bits - 1)) + 10 * step for step in range(3)] if signed else []
    got = frames(decoder.feed(b"".join(b"%d,1\n" % tick for tick in ticks)))
    times = [frame.device_time_us or 0 for frame in got]
    scale = 1000 if time is TextTime.MILLISECONDS else 1
    steps = [(after - before) % (2**bits * scale) for before, after in itertools.pairwise(times)]
    expected = [(b - a) % 2**bits * scale for a, b in itertools.pairwise(ticks)]
    assert steps == expected
    assert times == sorted(times)
    assert decoder.counts.faults == {}


def test_restart_is_seen_in_device_time() -> None:
    decoder = started(TextTime.MILLISECONDS)
    events = decoder.feed(b"900000,1\n900010,1\n5,1\n15,1\n")
    assert kinds(events) == [FaultKind.RESTART]
    assert frames(events)[-1].device_time_us == 15_000


def test_endless_lines_are_bounded_and_not_taken() -> None:
    decoder = started()
    for _ in range(100):
        decoder.feed(b"1," * 50)
        assert len(decoder._partial) <= MAX_LINE
    assert frames(decoder.feed(b"1,2\n3,4\n")) == frames(started().feed(b"3,4\n"))


PIECES = (b"1,2\n", b"boot\r\n", b"3 4\r", b"\xff\xfe\n", b"9;")


@given(st.lists(st.sampled_from(PIECES), max_size=9), st.lists(st.integers(0), max_size=8))
def test_cuts_change_nothing(lines: list[bytes], cuts: list[int]) -> None:
    data = b"".join(lines)
    whole, cut = started(), started()
    places = [0, *sorted(place % (len(data) + 1) for place in cuts), len(data)]
    events = [
        event for start, end in itertools.pairwise(places) for event in cut.feed(data[start:end])
    ]
    assert events == whole.feed(data)
    assert cut.counts == whole.counts


@given(st.binary(max_size=400) | st.text("0123456789.,;=:+-eEnaift \t\r\n", max_size=200))
def test_nothing_raises(data: bytes | str) -> None:
    decoder = started(TextTime.MICROSECONDS)
    decoder.feed(data if isinstance(data, bytes) else data.encode())
    assert frames(decoder.feed(b"\n7,1,2\n"))[-1].counts == (1, 2)


def test_a_million_random_bytes() -> None:
    rng = random.Random(2)
    decoder = TextDecoder(columns=8)
    for _ in range(250):
        assert frames(decoder.feed(rng.randbytes(4000))) == []
        assert len(decoder._partial) <= MAX_LINE
    assert decoder.counts.bytes == 1_000_000
