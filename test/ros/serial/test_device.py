from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import serial

from ros.serial.helpers import INFO, frames, kinds
from shoecal_ros.serial.channel_map import ChannelMap, Converter, DeviceChannel
from shoecal_ros.serial.device import SimulatedDevice, convert
from shoecal_ros.serial.errors import DeviceError
from shoecal_ros.serial.frame import FaultKind, Frame
from shoecal_ros.serial.protocol import INFO_REQUEST, BinaryDecoder

CONVERTER = Converter(volts_per_count=5.0 / 2**23)


@pytest.fixture
def port(device: SimulatedDevice, link: Path) -> Iterator[serial.Serial]:
    with serial.Serial(str(link), 115200, timeout=60.0, exclusive=True) as port:
        yield port


def send(device: SimulatedDevice, sequence: int) -> bool:
    return device.send(sequence, sequence * 10_000, [sequence, -1], [0, 0], temperature=21.5)


def sent(sequence: int) -> Frame:
    return Frame(sequence, sequence * 10_000, (0, 1), (0, 0), (sequence, -1), 21.5)


def test_frames_arrive_as_they_were_sent(device: SimulatedDevice, port: serial.Serial) -> None:
    assert all(send(device, sequence) for sequence in range(100))
    size = 23 + 6 * 2
    decoder = BinaryDecoder()
    info = decoder.feed(port.read_until(b"\0"))
    assert info == [INFO]
    assert frames(decoder.feed(port.read(100 * size))) == list(map(sent, range(100)))
    assert (device.sent, device.dropped) == (100, 0)


def test_info_is_sent_upon_request(device: SimulatedDevice, port: serial.Serial) -> None:
    send(device, 0)
    port.read_until(b"\0")
    port.write(b"noise" + INFO_REQUEST[:3])
    port.write(INFO_REQUEST[3:] + INFO_REQUEST[:3])
    decoder = BinaryDecoder()
    assert decoder.feed(port.read(35)) == [sent(0)]
    # The device looks for a request at each frame; the kernel hands its bytes over when it likes.
    answers: list[object] = []
    for sequence in range(1, 1000):
        send(device, sequence)
        answers += decoder.feed(port.read_until(b"\0"))
        if INFO in answers:
            break
    assert INFO in answers
    told = [one for one in answers if one != INFO]
    assert told == [sent(sequence) for sequence in range(1, len(told) + 1)]


def test_nobody_listens(device: SimulatedDevice, link: Path) -> None:
    assert not any(send(device, sequence) for sequence in range(1000))
    assert (device.sent, device.dropped) == (0, 1000)
    with serial.Serial(str(link), timeout=60.0) as port:
        assert send(device, 1000)
        port.read_until(b"\0")
        assert BinaryDecoder().feed(port.read_until(b"\0")) == [sent(1000)]
    assert not send(device, 1001)


def test_full_line_drops_whole_frames(link: Path) -> None:
    """Nobody reads, so the kernel's buffer fills; the frames in it are whole and in order."""
    with (
        SimulatedDevice(link, INFO, patience_s=0.001) as device,
        serial.Serial(str(link), timeout=0.2) as port,
    ):
        went = [send(device, sequence) for sequence in range(3000)]
        assert 0 < device.dropped < 3000
        assert device.sent + device.dropped == 3000
        data = b"".join(iter(lambda: port.read(4096), b""))
        send(device, 3000)
        data += b"".join(iter(lambda: port.read(4096), b""))
    decoder = BinaryDecoder()
    expected = [sent(sequence) for sequence, out in enumerate(went) if out]
    assert frames(decoder.feed(data)) == [*expected, sent(3000)]
    assert decoder.counts.faults == {FaultKind.LOST_FRAMES: device.dropped}


def test_faults(device: SimulatedDevice, port: serial.Serial) -> None:
    send(device, 0)
    device.corrupt_next(5, 9)
    send(device, 1)
    device.lose_frames(2)
    assert [send(device, sequence) for sequence in (2, 3, 4)] == [False, False, True]
    decoder = BinaryDecoder()
    data = b"".join(port.read_until(b"\0") for _ in range(4))
    events = decoder.feed(data)
    assert frames(events) == [sent(0), sent(4)]
    assert FaultKind.LOST_FRAMES in kinds(events)
    assert decoder.counts.faults[FaultKind.LOST_FRAMES] == 3


def test_plugging_makes_the_link_anew(device: SimulatedDevice, link: Path) -> None:
    assert link.is_char_device()
    device.unplug()
    assert not link.is_symlink()
    assert not send(device, 0)
    device.unplug()
    device.plug()
    device.plug()
    assert link.is_char_device()


def test_link_left_behind_is_replaced_but_no_file_is(link: Path, tmp_path: Path) -> None:
    link.symlink_to(tmp_path / "gone")
    with SimulatedDevice(link, INFO):
        assert link.is_char_device()
    link.write_text("precious")
    with pytest.raises(DeviceError, match="stands there"):
        SimulatedDevice(link, INFO)
    assert link.read_text() == "precious"
    with pytest.raises(DeviceError, match="check the folder"):
        SimulatedDevice(tmp_path / "none" / "port", INFO)


def test_nobody_takes_the_port_of_a_device_that_is_plugged_in(
    device: SimulatedDevice, link: Path
) -> None:
    before = link.readlink()
    with pytest.raises(DeviceError, match="another simulator that runs; end that one"):
        SimulatedDevice(link, INFO)
    assert link.readlink() == before
    device.close()
    SimulatedDevice(link, INFO).close()


def test_converter() -> None:
    volts = np.array([0.0, 1.0, -5.0, 5.0, 7.0, -np.inf, np.nan, 2e-7, 4e-7])
    counts, status = convert(volts, CONVERTER)
    assert counts.tolist() == [
        0, 1677722, -(2**23), 2**23 - 1, 2**23 - 1, -(2**23), 0, 0, 1,
    ]  # fmt: skip
    assert status.tolist() == [0, 0, 1, 1, 1, 1, 2, 0, 0]


def test_voltages_survive_conversion_to_half_a_count() -> None:
    volts = np.random.default_rng(1).uniform(-4.9, 4.9, 32)
    counts, status = convert(volts, CONVERTER)
    frame = Frame(0, 0, tuple(range(32)), tuple(map(int, status)), tuple(map(int, counts)))
    cells = ChannelMap(DeviceChannel(index, str(index), CONVERTER) for index in range(32))
    readings = cells.readings(frame)
    assert np.max(np.abs(np.array(readings.voltage) - volts)) <= CONVERTER.volts_per_count / 2
    assert set(readings.status) == {0}
