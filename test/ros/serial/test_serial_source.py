from __future__ import annotations

import errno
import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest
import serial

from ros.serial.helpers import INFO, Clock, MakeSource, ReadUntil, frame, frames, sealed
from shoecal_core.errors import FileError
from shoecal_ros.common.codes import Code
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.errors import (
    PortBusyError,
    PortError,
    PortMissingError,
    PortPermissionError,
)
from shoecal_ros.serial.frame import FaultKind
from shoecal_ros.serial.port import _port_error, open_port
from shoecal_ros.serial.protocol import encode_frame, encode_info
from shoecal_ros.serial.text_protocol import TextDecoder


def send(device: SimulatedDevice, *sequences: int) -> None:
    for sequence in sequences:
        assert device.send_bytes(encode_frame(frame(sequence)))


def test_frames_come_with_their_receipt(
    device: SimulatedDevice, make_source: MakeSource, read_until: ReadUntil, clock: Clock
) -> None:
    source = make_source()
    source.open()
    send(device, 0, 1)
    received = read_until(source, lambda got: len(frames(got)) == 2)
    assert frames(received) == [frame(0), frame(1)]
    assert {each.receive_ns for each in received} == {clock.now_ns()}
    status = source.status()
    assert status.connected
    assert status.problem is None
    assert status.age == 0
    assert status.info == INFO
    assert (status.counts.frames, status.reconnects) == (2, 0)
    clock.seconds += 1
    assert source.status().rate == 2
    assert source.status().age == 1


def test_device_is_asked_what_it_is(
    device: SimulatedDevice, make_source: MakeSource, read_until: ReadUntil, link: Path
) -> None:
    with serial.Serial(str(link), timeout=60.0) as other:
        device.send(0, 0, [0], [0])
        other.read_until(b"\0")  # what the device says at the opening
        source = make_source()
        source.open()
        other.close()
    count = iter(range(1, 1000))

    def asked_and_answered(_: object) -> bool:
        device.send(next(count), 10_000, [0], [0])
        return source.status().info is not None

    read_until(source, asked_and_answered)
    assert source.status().info == INFO


def test_reading_waits_no_longer_than_told(
    device: SimulatedDevice, make_source: MakeSource
) -> None:
    source = make_source()
    source.open()
    assert source.read(0.0) == []
    assert source.read(0.01) == []


def test_unplugged_and_plugged_in_again(
    device: SimulatedDevice, make_source: MakeSource, read_until: ReadUntil, clock: Clock
) -> None:
    source = make_source()
    source.open()
    send(device, 0)
    read_until(source, lambda got: len(frames(got)) == 1)
    device.unplug()
    read_until(source, lambda _: not source.status().connected)
    assert "plug it in again" in str(source.status().problem)
    for _ in range(40):
        source.read(0.0)
        clock.seconds += 0.5
    assert "does not exist" in str(source.status().problem)
    device.plug()
    replugged = clock.seconds
    read_until(source, lambda _: source.status().connected)
    assert clock.seconds - replugged < 2.0
    send(device, 7)
    assert frames(read_until(source, lambda got: bool(frames(got)))) == [frame(7)]
    status = source.status()
    assert status.problem is None
    assert status.reconnects == 1
    assert status.counts.faults == {FaultKind.LOST_FRAMES: 6}


def test_restart_of_the_device_is_counted(
    device: SimulatedDevice, make_source: MakeSource, read_until: ReadUntil
) -> None:
    source = make_source()
    source.open()
    send(device, 500, 0, 1)
    read_until(source, lambda got: len(frames(got)) == 3)
    assert source.status().counts.faults == {FaultKind.RESTART: 1}


def test_missing_port(make_source: MakeSource, link: Path) -> None:
    source = make_source()
    with pytest.raises(PortMissingError) as caught:
        source.open()
    message = str(caught.value)
    assert str(link) in message
    assert "there are:" in message
    assert "dialout" in message
    assert source.read(0.0) == []
    assert str(source.status().problem) == message
    assert not source.status().connected


def test_port_that_appears_later_is_opened_by_reading(
    make_source: MakeSource, link: Path, read_until: ReadUntil
) -> None:
    source = make_source()
    source.read(0.0)
    with SimulatedDevice(link, INFO) as device:
        read_until(source, lambda _: source.status().connected)
        send(device, 3)
        assert frames(read_until(source, lambda got: bool(frames(got)))) == [frame(3)]


def test_opened_twice(device: SimulatedDevice, make_source: MakeSource, link: Path) -> None:
    first, second = make_source(), make_source()
    first.open()
    with pytest.raises(PortBusyError, match=f"{link}.*another program"):
        second.open()
    second.read(0.0)
    assert "another program" in str(second.status().problem)
    first.close()
    second.open()


def test_opened_by_another_process(
    device: SimulatedDevice, make_source: MakeSource, link: Path
) -> None:
    program = (
        "import sys, serial; port = serial.Serial(sys.argv[1], exclusive=True);"
        "print('open', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program, str(link)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"open\n"
        with pytest.raises(PortBusyError):
            make_source().open()


def test_what_is_no_serial_port(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("text")
    for name in (tmp_path, tmp_path / "file", Path("/dev/null")):
        with pytest.raises(PortError, match="correct 'port'"):
            open_port(str(name), 115200)


def test_rate_that_no_port_can_do(device: SimulatedDevice, link: Path) -> None:
    with pytest.raises(PortError, match=r"-1 baud; correct 'baud'"):
        open_port(str(link), -1)


def test_permission_denied_names_the_group() -> None:
    error = _port_error("/dev/ttyX", serial.SerialException(errno.EACCES, "no"))
    assert isinstance(error, PortPermissionError)
    assert "usermod -a -G dialout" in str(error)


def test_silent_port(
    device: SimulatedDevice, make_source: MakeSource, clock: Clock, read_until: ReadUntil
) -> None:
    source = make_source()
    source.open()
    clock.seconds += 1.9
    assert source.status().problem is None
    clock.seconds += 0.2
    assert "no byte for 2.1 s" in str(source.status().problem)
    assert "cable" in str(source.status().problem)
    send(device, 0)
    read_until(source, lambda got: bool(frames(got)))
    assert source.status().problem is None
    clock.seconds += 3.0
    assert "no byte for 3.0 s" in str(source.status().problem)


@pytest.mark.parametrize(
    ("data", "text", "cure"),
    [
        (b"\x91\x80\x00\xfe\x00" * 50, False, "correct 'baud' (now 115200), or 'mode'"),
        (b"812,-44,17,90\r\n" * 20, False, "set 'mode' to text"),
        (sealed(b"\1\1")[:-2] + b"\7\0", False, "checksum"),
        (b"\x91\x80\x00\xfe\x0a" * 50, True, "set 'mode' to binary"),
        (b"812,-44,17,90\r\n" * 20, True, "4 values, expected 8"),
        (b"Hello, world\r\n" * 20, True, "Hello, world"),
    ],
    ids=["baud", "text", "checksum", "binary", "columns", "chatter"],
)
def test_garbage_names_its_cure(
    device: SimulatedDevice,
    make_source: MakeSource,
    read_until: ReadUntil,
    clock: Clock,
    data: bytes,
    text: bool,
    cure: str,
) -> None:
    source = make_source(TextDecoder(columns=8) if text else None)
    source.open()

    def send_and_read(total: int) -> None:
        clock.seconds += 1.1
        device.send_bytes(data)
        read_until(source, lambda _: source.status().counts.bytes == total)

    start = len(encode_info(INFO))
    send_and_read(start + len(data))
    send_and_read(start + 2 * len(data))
    problem = str(source.status().problem)
    assert "no good frame for 2.2 s" in problem
    assert cure in problem
    assert "\n" not in problem


def test_device_of_another_version_is_named(
    device: SimulatedDevice, make_source: MakeSource, read_until: ReadUntil, clock: Clock
) -> None:
    source = make_source()
    source.open()
    device.send_bytes(sealed(b"\x02\x01"))
    clock.seconds += 2.5
    read_until(source, lambda _: source.status().counts.faults.total() > 0)
    problem = source.status().problem
    assert problem is not None
    assert "protocol version 2" in problem.message
    assert problem.code == Code.FIRMWARE_VERSION


def test_text_with_chatter(
    device: SimulatedDevice, make_source: MakeSource, read_until: ReadUntil
) -> None:
    source = make_source(TextDecoder(columns=2))
    source.open()
    device.send_bytes(b"\n")
    read_until(source, lambda _: source.status().counts.bytes > 0)
    before = source.status().counts.faults[FaultKind.CHATTER]
    device.send_bytes(b"boot...\r\n1,2\r\nHX711 ok\r\n3;4\r\n")
    got = frames(read_until(source, lambda got: len(frames(got)) == 2))
    assert [frame.counts for frame in got] == [(1, 2), (3, 4)]
    assert got[0].device_time_us is None
    assert source.status().counts.faults == {FaultKind.CHATTER: before + 2}


def test_raw_log_takes_every_byte(
    device: SimulatedDevice, make_source: MakeSource, read_until: ReadUntil, tmp_path: Path
) -> None:
    path = tmp_path / "bytes.bin"
    path.write_bytes(b"before")
    source = make_source(raw_log=path)
    source.open()
    garbage = bytes(range(256)) + b"\0"
    device.send_bytes(garbage)
    send(device, 0)
    read_until(source, lambda got: bool(frames(got)))
    content = path.read_bytes()
    assert content.startswith(b"before")
    assert content.endswith(garbage + encode_frame(frame(0)))
    assert len(content) == len(b"before") + source.status().counts.bytes


def test_raw_log_that_cannot_be_written(make_source: MakeSource, tmp_path: Path) -> None:
    with pytest.raises(FileError, match="raw_log"):
        make_source(raw_log=tmp_path / "none" / "bytes.bin")


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a full disk")
def test_full_disk_ends_the_log_but_not_the_driver(
    device: SimulatedDevice, make_source: MakeSource, read_until: ReadUntil
) -> None:
    source = make_source(raw_log=Path("/dev/full"))
    source.open()
    for sequence in range(2):
        send(device, sequence)
        read_until(source, lambda got: bool(frames(got)))
    assert "log of raw bytes ended" in str(source.status().problem)
    assert os.strerror(errno.ENOSPC) in str(source.status().problem)


def test_closing_ends_reading(device: SimulatedDevice, make_source: MakeSource) -> None:
    source = make_source()
    source.open()
    reader = threading.Thread(target=source.read, args=(0.2,))
    reader.start()
    source.close()
    reader.join(5.0)
    assert not reader.is_alive()
    assert source.read(10.0) == []
    assert "closed" in str(source.status().problem)


def test_closing_ends_waiting_for_a_port(make_source: MakeSource) -> None:
    source = make_source()
    for _ in range(3):
        source.read(0.0)
    reader = threading.Thread(target=source.read, args=(60.0,))
    reader.start()
    source.close()
    reader.join(5.0)
    assert not reader.is_alive()
