from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from ros.serial.helpers import Clock, MakeSource, ReadUntil, frame, frames, kinds
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.errors import ReplayError
from shoecal_ros.serial.frame import FaultKind, Frame
from shoecal_ros.serial.protocol import BinaryDecoder, encode_frame
from shoecal_ros.serial.replay import LONGEST_PAUSE_US, ReplaySource
from shoecal_ros.serial.text_protocol import TextDecoder, TextTime

START = 1_000_000_000_000


def replay(path: Path, clock: Clock, start_ns: int | None = START) -> ReplaySource:
    decoder = BinaryDecoder()
    return ReplaySource(path, decoder, clock.now_ns, start_ns=start_ns, monotonic=clock.monotonic)


def test_frames_come_at_the_pace_of_the_device(tmp_path: Path, clock: Clock) -> None:
    path = tmp_path / "bytes.bin"
    path.write_bytes(b"".join(encode_frame(frame(sequence)) for sequence in range(1000)))
    source = replay(path, clock, start_ns=None)
    begun = clock.now_ns()
    assert frames(source.read(0.0)) == [frame(0)]
    assert frames(source.read(0.0)) == []
    clock.seconds += 0.02
    received = source.read(0.0)
    assert frames(received) == [frame(1), frame(2)]
    assert [each.receive_ns - begun for each in received] == [10_000_000, 20_000_000]
    assert source.status().connected
    clock.seconds += 100.0
    rest = []
    while source.status().connected:
        rest += frames(source.read(0.0))
    assert rest == [frame(sequence) for sequence in range(3, 1000)]
    assert "to its end" in str(source.status().problem)
    assert source.status().counts.frames == 1000
    source.close()
    assert source.read(0.0) == []


def test_restart_in_the_log_goes_on(tmp_path: Path, clock: Clock) -> None:
    path = tmp_path / "bytes.bin"
    path.write_bytes(b"".join(encode_frame(frame(sequence)) for sequence in (70, 71, 0, 1)))
    clock.seconds = 1e6
    received = replay(path, clock).read(0.0)
    receipts = [each.receive_ns - START for each in received if isinstance(each.event, Frame)]
    assert receipts == [0, 10_000_000, 10_000_000, 20_000_000]
    assert kinds(each.event for each in received) == [FaultKind.RESTART]


def test_a_clock_that_jumps_by_years_is_not_waited_for(tmp_path: Path, clock: Clock) -> None:
    path = tmp_path / "bytes.bin"
    far = replace(frame(1), device_time_us=2**62)
    path.write_bytes(b"".join(map(encode_frame, (frame(0), far, frame(2)))))
    clock.seconds = START / 1e9 + LONGEST_PAUSE_US / 1e6
    source = replay(path, clock)
    assert frames(source.read(0.0)) == [frame(0), far, frame(2)]
    assert source.read(0.0) == []
    assert not source.status().connected


def test_what_was_logged_is_replayed(
    device: SimulatedDevice,
    make_source: MakeSource,
    read_until: ReadUntil,
    clock: Clock,
    tmp_path: Path,
) -> None:
    path = tmp_path / "bytes.bin"
    live = make_source(raw_log=path)
    live.open()
    for sequence in range(20):
        if sequence == 5:
            device.corrupt_next(3)
        device.send(sequence, sequence * 10_000, [sequence], [0])
    seen = read_until(live, lambda got: len(frames(got)) == 19)
    live.close()
    clock.seconds = 1e6
    source = replay(path, clock)
    assert [each.event for each in source.read(0.0)] == [each.event for each in seen]
    assert source.status().info == live.status().info
    assert source.status().counts == live.status().counts


def test_text_needs_device_time(tmp_path: Path, clock: Clock) -> None:
    path = tmp_path / "bytes.txt"
    path.write_bytes(b"\n100,1,2\n110,3,4\n")
    clock.seconds = 1e6
    timed = ReplaySource(path, TextDecoder(TextTime.MILLISECONDS), clock.now_ns, start_ns=START)
    assert [each.receive_ns - START for each in timed.read(0.0)] == [0, 10_000_000]
    with pytest.raises(ReplayError, match="no device time"):
        ReplaySource(path, TextDecoder(), clock.now_ns).read(0.0)


def test_missing_log(tmp_path: Path, clock: Clock) -> None:
    with pytest.raises(ReplayError, match=r"none\.bin"):
        replay(tmp_path / "none.bin", clock)


@pytest.mark.parametrize("content", [b"", b"\0", b"no frames at all"])
def test_log_without_frames_ends(tmp_path: Path, clock: Clock, content: bytes) -> None:
    path = tmp_path / "bytes.bin"
    path.write_bytes(content)
    source = replay(path, clock)
    assert frames(source.read(0.0)) == []
    assert not source.status().connected


def test_a_log_of_which_no_line_is_understood_says_so(tmp_path: Path, clock: Clock) -> None:
    path = tmp_path / "openscale.log"
    path.write_bytes(b"\n" + 20 * b"12.34,lbs,\n")
    source = ReplaySource(path, TextDecoder(TextTime.MILLISECONDS), clock.now_ns)
    while source.status().connected:
        source.read(0.0)
    problem = source.status().problem
    assert problem is not None
    assert (
        "has no good frame: correct 'mode' or 'text' (last fault: words between" in problem.message
    )
