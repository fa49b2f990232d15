from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from ros.serial.helpers import INFO, Clock, frame
from shoecal_ros.serial.channel_map import Converter, DeviceChannel
from shoecal_ros.serial.config import DriverConfig, Mode
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.driver import Reading, SerialDriver, open_driver
from shoecal_ros.serial.errors import PortMissingError
from shoecal_ros.serial.protocol import encode_frame
from shoecal_ros.serial.text_protocol import TextTime

VOLTS = Converter(0.001)
MS = 1_000_000


@pytest.fixture
def config(link: Path) -> DriverConfig:
    return DriverConfig(
        port=str(link),
        baud=115200,
        mode=Mode.BINARY,
        text_time=TextTime.NONE,
        text_columns=2,
        latency_ns=0,
        alarm_s=60.0,
        raw_log=None,
        channels=(DeviceChannel(0, "left/a", VOLTS), DeviceChannel(1, "right/a", VOLTS)),
    )


Open = Callable[[DriverConfig], SerialDriver]


@pytest.fixture
def open_it(clock: Clock) -> Iterator[Open]:
    drivers = []

    def make(config: DriverConfig) -> SerialDriver:
        driver = open_driver(config, clock.now_ns)
        drivers.append(driver)
        driver.open()
        return driver

    yield make
    for driver in drivers:
        driver.close()


def read(driver: SerialDriver, count: int) -> list[Reading]:
    readings: list[Reading] = []
    for _ in range(200):
        readings += driver.read(0.05)
        if len(readings) >= count:
            return readings
    raise AssertionError(f"waited in vain; {driver.status()}")


def test_readings_carry_cells_and_the_time_of_sampling(
    device: SimulatedDevice, config: DriverConfig, open_it: Open, clock: Clock
) -> None:
    driver = open_it(config)
    clock.seconds = 1780000000.123456
    readings = []
    for sequence in range(3):
        clock.seconds += 0.01
        device.send(sequence, 5_000_000 + sequence * 10_000, [1500, -20], [0, 2], temperature=21.5)
        readings += read(driver, 1)
    last = readings[-1]
    assert last.sequence == 2
    assert last.cells.cell == ("left/a", "right/a")
    assert last.cells.voltage[0] == pytest.approx(1.5)
    assert math.isnan(last.cells.voltage[1])
    assert last.cells.status == (0, 2)
    assert last.temperature == 21.5
    assert abs(last.stamp_ns - clock.now_ns()) < 1000
    assert last.stamp_ns - readings[0].stamp_ns == pytest.approx(20 * MS, abs=1000)
    assert driver.status().problem is None


def test_known_latency_is_taken_off(
    device: SimulatedDevice, config: DriverConfig, open_it: Open, clock: Clock
) -> None:
    driver = open_it(replace(config, latency_ns=6 * MS))
    device.send(0, 5, [1, 2], [0, 0])
    (reading,) = read(driver, 1)
    assert reading.stamp_ns == clock.now_ns() - 6 * MS
    assert math.isnan(reading.temperature)


def test_simulated_time_is_taken_from_the_device(
    device: SimulatedDevice, config: DriverConfig, open_it: Open, clock: Clock
) -> None:
    """As in a simulation: the host's clock goes in steps of 10 ms and shows them late."""
    driver = open_it(config)
    stamps = []
    for step in range(1, 200):
        clock.seconds = max(1, step - 2) // 2 * 0.02
        device.send(step, step * 10_000, [1, 2], [0, 0])
        stamps += [reading.stamp_ns for reading in driver.read(1.0)]
    # Nothing is published before the clock runs.
    assert stamps == [step * 10 * MS for step in range(4, 200)]


def test_a_clock_that_does_not_run_is_told_as_such(
    device: SimulatedDevice, config: DriverConfig, open_it: Open, clock: Clock
) -> None:
    driver = open_it(config)
    for sequence in (0, 2):
        clock.seconds = 0.0
        device.send(sequence, 10_000 + 10_000 * sequence, [1, 2], [0, 0])
        assert driver.read(1.0) == []
        assert "the clock stands still; start what publishes /clock" in str(driver.status().problem)
        clock.seconds = 0.02
        device.send(sequence + 1, 20_000 + 10_000 * sequence, [1, 2], [0, 0])
        assert len(read(driver, 1)) == 1
        assert driver.status().problem is None


def test_a_clock_that_stands_is_told_until_it_runs_again(
    device: SimulatedDevice, config: DriverConfig, open_it: Open, clock: Clock
) -> None:
    driver = open_it(config)
    clock.seconds = 50.0
    for sequence in range(25):
        device.send(sequence, 100_000 * sequence, [1, 2], [0, 0])
        assert len(read(driver, 1)) == 1
        reported = str(driver.status().problem)
        assert ("the clock stands still" in reported) == (sequence > 20)
    clock.seconds = 50.1
    device.send(25, 2_500_000, [1, 2], [0, 0])
    assert len(read(driver, 1)) == 1
    assert driver.status().problem is None


def test_lines_without_time_are_stamped_on_receipt(
    device: SimulatedDevice, config: DriverConfig, open_it: Open, clock: Clock
) -> None:
    driver = open_it(replace(config, mode=Mode.TEXT))
    device.send_bytes(b"\n1,2\n3,4\n")
    readings = read(driver, 2)
    assert [reading.stamp_ns for reading in readings] == [clock.now_ns(), clock.now_ns() + 1]


def test_restart_of_the_device_begins_the_mapping_anew(
    device: SimulatedDevice, config: DriverConfig, open_it: Open, clock: Clock
) -> None:
    driver = open_it(config)
    clock.seconds = 1780000000.123456
    # So soon after its start that device time does not go back, but the sequence does.
    for sequence, time_us in ((100, 1_000_000), (101, 1_010_000), (0, 1_500_000), (1, 1_510_000)):
        clock.seconds += 0.01 if sequence else 3.0
        device.send(sequence, time_us, [1, 2], [0, 0])
        (reading,) = read(driver, 1)
        assert abs(reading.stamp_ns - clock.now_ns()) < 1000
    assert driver.status().clock_resets == 1


def test_channels_that_do_not_match_are_named(
    device: SimulatedDevice, config: DriverConfig, open_it: Open
) -> None:
    driver = open_it(config)
    device.send(0, 0, [1], [0])
    read(driver, 1)
    assert "sends nothing for right/a" in str(driver.status().problem)
    device.send(1, 1, [1, 2, 3, 4], [0] * 4)
    assert read(driver, 1)[0].cells.cell == ("left/a", "right/a")
    assert driver.status().unknown == {2: 1, 3: 1}
    assert "no cell for channel 2, 3" in str(driver.status().problem)


def test_troubles_of_the_port_come_first(
    device: SimulatedDevice, config: DriverConfig, open_it: Open
) -> None:
    driver = open_it(config)
    device.unplug()
    for _ in range(3):
        driver.read(0.05)
    assert str(config.port) in str(driver.status().problem)
    with pytest.raises(PortMissingError):
        open_it(config)


def test_plain_file_is_replayed(
    config: DriverConfig, open_it: Open, clock: Clock, tmp_path: Path
) -> None:
    path = tmp_path / "bytes.bin"
    path.write_bytes(b"".join(encode_frame(frame(sequence)) for sequence in range(50)))
    driver = open_it(replace(config, port=str(path)))
    readings = driver.read(0.0)
    clock.seconds += 10.0
    readings += driver.read(0.0)
    assert [reading.sequence for reading in readings] == list(range(50))
    steps = {after.stamp_ns - before.stamp_ns for before, after in itertools.pairwise(readings)}
    assert steps == {10 * MS}


def test_a_second_of_a_fast_device(config: DriverConfig, link: Path, open_it: Open) -> None:
    with SimulatedDevice(link, INFO) as device:
        driver = open_it(config)
        readings: list[Reading] = []
        for sequence in range(1000):
            device.send(sequence, sequence * 1000, [sequence, -sequence], [0, 0])
            if sequence % 16 == 15:
                readings += driver.read(1.0)
        readings += read(driver, 1000 - len(readings))
    assert [reading.sequence for reading in readings] == list(range(1000))
    assert driver.status().source.counts.faults == {}
