"""The real driver reads the firmware: compiled for this computer, and emulated as a board.

Converters are simulated in both; on the emulated board the firmware's own machine code clocks them.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ros.firmware.board import Board, make, need_avr, need_emulator, refused
from shoecal_ros.serial.driver import Reading, SerialDriver, open_driver
from shoecal_ros.serial.frame import ChannelStatus, FaultKind

Boards = Callable[..., Board]
PATIENCE_S = 60.0
GOOD, SATURATED = ChannelStatus.GOOD, ChannelStatus.SATURATED
NO_DATA, FAULT = ChannelStatus.NO_DATA, ChannelStatus.FAULT


@pytest.fixture(scope="module")
def build(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("build")


@pytest.fixture(params=["host", "emulated"])
def boards(request: pytest.FixtureRequest, build: Path) -> Boards:
    """Makes a board with given converters."""
    if request.param == "host":
        program = [make(build, "host") / "shoe_host"]
    else:
        need_emulator()
        make(build, "all", "emulator")
        program = [build / "shoe_emulator", build / "shoe.elf"]
    return lambda *converters: Board(program, *converters)


def read(driver: SerialDriver, enough: Callable[[list[Reading]], bool]) -> list[Reading]:
    readings: list[Reading] = []
    until = time.monotonic() + PATIENCE_S
    while not enough(readings):
        assert time.monotonic() < until, f"waited in vain; {driver.status()}"
        readings += driver.read(0.05)
    return readings


def settled(readings: list[Reading]) -> list[Reading]:
    """Once every converter that lives has given something."""
    first = next(
        place for place, reading in enumerate(readings) if NO_DATA not in reading.cells.status[:4]
    )
    return readings[first:]


def test_counts_arrive_as_the_converters_gave_them(boards: Boards) -> None:
    """Signs, ends of the range, converters that are dead or whose line lies at ground."""
    given = (1000, -1000, 8388607, -8388608, "dead", "short", 0, 77)
    with boards(*given) as board:
        driver = open_driver(board.config(8), time.time_ns)
        readings = settled(read(driver, lambda all_: len(all_) > 40))
        status = driver.status()
        driver.close()
    for reading in readings[1:]:
        volts, states = reading.cells.voltage, reading.cells.status
        for k in (0, 1, 6, 7):
            base = given[k]
            assert isinstance(base, int)
            assert states[k] == GOOD
            assert 0 <= volts[k] - base <= 15
        assert states[2] == SATURATED
        assert volts[2] == 8388607
        assert states[3] == (SATURATED if volts[3] == -8388608 else GOOD)
        assert states[4:6] == (NO_DATA, FAULT)
        assert np.isnan(volts[4])
    assert len({reading.cells.voltage[0] for reading in readings}) > 8
    assert set(status.source.counts.faults) <= {FaultKind.LOST_FRAMES}
    assert status.source.info is not None
    assert status.source.info.firmware == "shoecal-hx711 1.0"
    assert status.source.info.channels == 8
    assert status.problem is None


def test_time_goes_on_evenly(boards: Boards) -> None:
    """Every sampling has a number and a time of its own, later than the one before."""
    with boards(*range(8)) as board:
        driver = open_driver(board.config(8), time.time_ns)
        readings = settled(read(driver, lambda all_: len(all_) > 60))
        driver.close()
    # A busy computer may lose frames, whole ones; their numbers and times go on.
    numbers = np.array([reading.sequence for reading in readings])
    stamps = np.array([reading.stamp_ns for reading in readings]) * 1e-9
    assert np.all(np.diff(numbers) >= 1)
    assert np.all(np.diff(stamps) > 0.0)


def test_firmware_of_another_version_is_told(build: Path) -> None:
    folder = make(build / "next", "host", "EXTRA=-DPROTOCOL_VERSION=2")
    with Board([folder / "shoe_host"], *range(8)) as board:
        driver = open_driver(board.config(8), time.time_ns)
        until = time.monotonic() + PATIENCE_S
        while "version" not in str(driver.status().problem):
            assert time.monotonic() < until, driver.status()
            assert driver.read(0.05) == []
        problem = str(driver.status().problem)
        driver.close()
    assert "the device speaks protocol version 2, this driver 1; update the driver" in problem


def test_boards_of_fewer_channels_that_begin_elsewhere(build: Path) -> None:
    """Two boards for two feet: the second one's channels go on where the first one's end."""
    folder = make(build / "second", "host", "CHANNELS=4", "FIRST_CHANNEL=4")
    with Board([folder / "shoe_host"], 10, 20, 30, 40) as board:
        driver = open_driver(board.config(8), time.time_ns)
        reading = settled(read(driver, lambda all_: len(all_) > 10))[-1]
        driver.close()
    assert reading.cells.cell == ("left/4", "left/5", "left/6", "left/7")
    assert [int(volts) // 10 * 10 for volts in reading.cells.voltage] == pytest.approx(
        [10, 20, 30, 40], abs=10
    )


def test_the_board_s_firmware_compiles(build: Path) -> None:
    need_avr()
    assert (make(build, "all") / "shoe.elf").stat().st_size > 1000


def test_a_compiler_that_is_missing_is_named_with_its_packages(tmp_path: Path) -> None:
    assert "no-such-gcc is missing; sudo apt install gcc-avr avr-libc" in refused(
        tmp_path, "AVR_CC=no-such-gcc -O1"
    )
