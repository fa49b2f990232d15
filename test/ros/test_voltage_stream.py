"""The driver's voltages as lines of text: real DDS, a real process, real pipes."""

from __future__ import annotations

import json
import os
import select
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import IO, Any

import numpy as np
import pytest
from shoecal_msgs.msg import ShoeVoltages

from ros.bodies import NAO_SHOE, nao_shoe
from ros.world import END_S, World
from shoecal_core.cli.manual_guide_frames import LineFrame, LineProblem
from shoecal_core.cli.manual_guide_streams import FrameStream, driver_stream
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.workspace import ros_environment
from shoecal_ros.common.conversions import voltages_to_ros
from shoecal_ros.common.voltage_frame import VoltageFrame

NAMES = nao_shoe().names
LEFT, RIGHT = NAMES[:4], NAMES[4:]
VOLTS = np.arange(8) / 10.0


def message(
    index: int, cells: tuple[str, ...] = NAMES, source: str = "driver", status: int = 0
) -> ShoeVoltages:
    """One frame of a board."""
    frame = VoltageFrame(
        stamp_ns=1_000_000_000 + index * 10_000_000,
        source=source,
        sequence=index,
        cells=cells,
        voltage=VOLTS[[NAMES.index(name) for name in cells]] + index,
        status=np.full(len(cells), status, dtype=np.uint8),
    )
    return voltages_to_ros(frame)


class Lines:
    """What the process prints, as it comes."""

    def __init__(self, world: World, output: IO[bytes]) -> None:
        self._world = world
        self._output = output
        self._rest = b""
        self.heard: list[dict[str, Any]] = []

    def received(self) -> int:
        """Take what there is; how many lines there have been."""
        while select.select([self._output], [], [], 0.0)[0]:
            data = os.read(self._output.fileno(), 1 << 16)
            if not data:
                break
            *lines, self._rest = (self._rest + data).split(b"\n")
            self.heard += map(json.loads, lines)
        return len(self.heard)

    def until(self, number: int) -> dict[str, Any]:
        """Wait for a line."""
        self._world.until(lambda: self.received() >= number)
        return self.heard[number - 1]


@contextmanager
def streaming(*parameters: str) -> Iterator[subprocess.Popen[bytes]]:
    """The process; ended at the end if it has not ended itself."""
    words = [part for one in (f'shoe_file:="{NAO_SHOE}"', *parameters) for part in ("-p", one)]
    process = subprocess.Popen(
        [sys.executable, "-m", "shoecal_ros.voltage_stream", "--ros-args", *words],
        env=ros_environment(), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def test_every_frame_is_a_line(world: World) -> None:
    with streaming() as process:
        assert process.stdout is not None
        lines = Lines(world, process.stdout)
        publisher = world.publisher(ShoeVoltages, "shoe/voltages")
        for index in range(1, 6):
            publisher.publish(message(index))
            assert lines.until(index) == {
                "stamp_ns": 1_000_000_000 + index * 10_000_000,
                "cells": list(NAMES),
                "voltages": pytest.approx((VOLTS + index).tolist()),
                "status": [0] * 8,
            }
        process.send_signal(signal.SIGINT)
        assert process.wait(END_S) == 0


def test_frames_with_subsets_of_the_cells_are_joined(world: World) -> None:
    """One board a shoe, sampling at the same times."""
    with streaming() as process:
        assert process.stdout is not None
        lines = Lines(world, process.stdout)
        publisher = world.publisher(ShoeVoltages, "shoe/voltages")
        publisher.publish(message(1, RIGHT, "right_board"))
        first = lines.until(1)
        assert first["voltages"][:4] == [None] * 4
        assert first["status"][:4] == [2] * 4
        # Whichever board gives the instants: before long every line holds both.
        for index in range(2, 30):
            publisher.publish(message(index, RIGHT, "right_board"))
            publisher.publish(message(index, LEFT, "left_board"))
            lines.until(index)
        for line in lines.heard[-10:]:
            assert None not in line["voltages"]
            left, right = np.array(line["voltages"]).reshape(2, 4)
            assert np.ptp(left - VOLTS[:4]) < 1e-9
            assert np.ptp(right - VOLTS[4:]) < 1e-9
            assert abs(np.rint(left[0] - VOLTS[0]) - np.rint(right[0] - VOLTS[4])) <= 1


@pytest.mark.parametrize("odd", [np.inf, -np.inf, np.nan])
def test_a_voltage_that_is_no_number_is_none(world: World, odd: float) -> None:
    with streaming() as process:
        assert process.stdout is not None
        lines = Lines(world, process.stdout)
        publisher = world.publisher(ShoeVoltages, "shoe/voltages")
        sent = message(1)
        sent.voltage[2] = odd
        publisher.publish(sent)
        assert lines.until(1)["voltages"] == [*(VOLTS[:2] + 1), None, *(VOLTS[3:] + 1)]
        assert lines.until(1)["status"] == [0, 0, 2, 0, 0, 0, 0, 0]
        publisher.publish(message(2))
        assert lines.until(2)["status"] == [0] * 8


def test_what_is_wrong_is_told_once(world: World) -> None:
    with streaming("stale_s:=0.2") as process:
        assert process.stdout is not None
        lines = Lines(world, process.stdout)
        assert lines.until(1) == {"problem": "no voltages yet; start shoe_driver"}
        publisher = world.publisher(ShoeVoltages, "shoe/voltages")
        publisher.publish(message(1))
        assert lines.until(2)["stamp_ns"] == 1_010_000_000
        assert "check shoe_driver and its device" in lines.until(3)["problem"]
        foreign = message(3)
        foreign.cell = ["left/nose", *NAMES[1:]]
        publisher.publish(foreign)
        assert "cell 'left/nose'" in lines.until(4)["problem"]


def test_it_ends_with_who_reads_it() -> None:
    """Also where nothing comes that it could fail to write."""
    with streaming("stale_s:=0.2") as process:
        assert process.stdout is not None
        assert process.stdout.readline().startswith(b'{"problem"')
        process.stdout.close()
        process.stdout = None
        assert process.wait(END_S) == 0
        assert process.stderr is not None
        # Its log has what was wrong, and nothing of how it ended.
        lines = process.stderr.read().decode().splitlines()
        assert all("[voltage_stream]: voltages: no voltages yet" in line for line in lines)


def test_it_tells_how_voltages_come(world: World) -> None:
    with streaming("stale_s:=60.0") as process:
        assert process.stdout is not None
        lines = Lines(world, process.stdout)
        publisher = world.publisher(ShoeVoltages, "shoe/voltages")
        for count, index in enumerate((1, 2, 5), start=1):
            publisher.publish(message(index))
            lines.until(count)
        status = world.until_reported("voltage_stream", "voltages", "voltages come")

        def reported() -> dict[str, str]:
            status = world.diagnosis("voltage_stream", "voltages")
            return {pair.key: pair.value for pair in status.values}

        world.until(lambda: reported()["lost_frames"] == "2")
        assert status.hardware_id == "voltage_stream"
        assert reported()["left_out_frames"] == "0"
        assert float(reported()["age_s"]) >= 0.0


def test_a_message_that_makes_no_sense_is_told_once(world: World) -> None:
    with streaming("stale_s:=0.2") as process:
        assert process.stdout is not None
        lines = Lines(world, process.stdout)
        assert lines.until(1) == {"problem": "no voltages yet; start shoe_driver"}
        publisher = world.publisher(ShoeVoltages, "shoe/voltages")
        odd = message(1)
        odd.voltage = odd.voltage[:3]
        publisher.publish(odd)
        assert "3 voltages and 8 statuses" in lines.until(2)["problem"]
        assert "no voltages" in lines.until(3)["problem"]


def test_a_shoe_file_that_is_none_is_one_line() -> None:
    with streaming('shoe_file:="/not/there.yaml"') as process:
        assert process.wait(END_S) == 1
        assert process.stderr is not None
        (line,) = process.stderr.read().decode().splitlines()
        assert "/not/there.yaml: cannot be read" in line


# ---- as the guide hears it ----------------------------------------------------------------------


def take(stream: FrameStream, found: list[LineFrame | LineProblem]) -> int:
    if select.select([stream.descriptor], [], [], 0.0)[0]:
        stream.receive()
    found += stream.frames()
    return len(found)


def test_the_guide_hears_the_driver(world: World) -> None:
    with driver_stream(nao_shoe()) as stream:
        assert stream.live
        publisher = world.publisher(ShoeVoltages, "shoe/voltages")
        found: list[LineFrame | LineProblem] = []
        for index, status in enumerate((0, 0, 3), start=1):
            publisher.publish(message(index, status=status))
            world.until(partial(_taken, stream, found, index))
        _, second, third = found
        assert isinstance(second, LineFrame)
        assert isinstance(third, LineFrame)
        np.testing.assert_allclose(second.readings, VOLTS + 2)
        assert second.stamp_ns == 1_020_000_000
        assert np.isnan(third.readings).all()


def _taken(stream: FrameStream, found: list[LineFrame | LineProblem], wanted: int) -> bool:
    if select.select([stream.descriptor], [], [], 0.0)[0]:
        stream.receive()
    found += stream.frames()
    return len(found) >= wanted


def test_the_guide_tells_why_the_stream_ended(tmp_path: Path) -> None:
    path = tmp_path / "shoe.yaml"
    shutil.copy(NAO_SHOE, path)
    shoe = load_shoe(path)
    path.unlink()
    with driver_stream(shoe) as stream:
        while not stream.ended:
            stream.receive()
        assert "shoe.yaml: cannot be read" in str(stream.complain())
