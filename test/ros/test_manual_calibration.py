"""A manual calibration on its way to the robot: live voltages in, its file to the nodes."""

from __future__ import annotations

import time
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from rclpy.serialization import deserialize_message, serialize_message
from shoecal_msgs.msg import ShoeCalibration, ShoeVoltages
from shoecal_msgs.srv import GetCalibration, SetCalibration

from core.cli.terminal import Terminal
from core.shoe import mutations
from ros.bodies import ROOT, nao_shoe
from ros.world import World
from shoecal_core import cli
from shoecal_core.estimation.calibration import Calibration, load_calibration
from shoecal_core.manual.loads import CELLS, Load
from shoecal_core.manual.measurements_file import load_measurements
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.rig import LoadingRig
from shoecal_core.simulation.sampled_robot import draw_shoes
from shoecal_core.workflows.simulated_manual import rig_readings
from shoecal_ros.common.conversions import calibration_from_ros, calibration_to_ros, voltages_to_ros
from shoecal_ros.common.voltage_frame import VoltageFrame


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the simulated bench leaves."""
    folder = tmp_path_factory.mktemp("bench")
    assert cli.main(["manual", "simulate", "--seed", "1", "--out", str(folder)]) == 0
    return folder


def same(found: Calibration, original: Calibration) -> None:
    for name in ("id", "source", "made_ns", "robot", "shoe", "robot_hash", "shoe_hash",
                 "channels", "weight", "time_offset", "verdict", "reasons"):  # fmt: skip
        assert getattr(found, name) == getattr(original, name)
    np.testing.assert_array_equal(found.parameters.gain, original.parameters.gain)
    np.testing.assert_array_equal(found.parameters.offset, original.parameters.offset)
    assert found.covariance is not None
    assert original.covariance is not None
    np.testing.assert_array_equal(found.covariance, original.covariance)
    assert [one.foot for one in found.corrections] == [0, 1]
    for one, other in zip(found.corrections, original.corrections, strict=True):
        for part in ("x", "y", "cop_range", "output_range"):
            np.testing.assert_array_equal(getattr(one, part), getattr(other, part))


def test_its_file_comes_back_from_the_wire(folder: Path) -> None:
    original = load_calibration(folder / "calibration.yaml")
    message = deserialize_message(serialize_message(calibration_to_ros(original)), ShoeCalibration)
    same(calibration_from_ros(message), original)


def test_the_calibrator_takes_it(world: World, folder: Path) -> None:
    """The whole one at once; that of the cells alone warns, so only when forced."""
    state = {"state_dir": world.folder / "state", "sessions_dir": world.folder / "sessions"}
    world.start("calibrator", state)
    # The bench is simulated, the node's time is not.
    cells, whole = (
        replace(load_calibration(folder / f"{name}.yaml"), made_ns=time.time_ns())
        for name in ("cells", "calibration")
    )

    def put(calibration: Calibration, *, force: bool = False) -> SetCalibration.Response:
        request = SetCalibration.Request(calibration=calibration_to_ros(calibration), force=force)
        return world.call(SetCalibration, "shoe/set_calibration", request)

    refused = put(cells)
    assert not refused.success
    assert "load the shoe next" in refused.message
    assert put(cells, force=True).success
    taken = put(whole)
    assert taken.success, taken.message
    found = world.call(GetCalibration, "shoe/get_calibration", GetCalibration.Request())
    assert found.calibrated
    same(calibration_from_ros(found.calibration), whole)


def test_a_guided_session_with_the_running_driver(world: World, tmp_path: Path) -> None:
    """Two loads at a terminal, read from `shoe/voltages`."""
    shoe = nao_shoe()
    reality = load_reality(ROOT / "config" / "realities" / "default.yaml")
    rig = LoadingRig(shoe, reality, draw_shoes(reality, shoe, 1), np.random.default_rng(1))
    data, settings = tmp_path / "cells_data.yaml", tmp_path / "manual.yaml"
    mutations.write_edited(settings, ROOT / "config" / "manual.yaml", (("samples",), 5))
    words = ["manual", "cells", data, "--out", tmp_path / "cells.yaml", "--live"]
    with Terminal([*words, "--settings", settings]) as terminal:
        publisher = world.publisher(ShoeVoltages, "shoe/voltages")
        numbers = count(1)

        def fed(load: Load, text: str) -> bool:
            """Send one more frame; whether the text has come."""
            index = next(numbers)
            row = rig_readings(rig, load, 1).voltages[0]
            frame = VoltageFrame(
                10_000_000 * index, "driver", index, shoe.names, row, np.zeros(8, np.uint8)
            )
            publisher.publish(voltages_to_ros(frame))
            return terminal.shows(text)

        for number, mass in ((1, 0.0), (2, 1.0)):
            terminal.until(f"{number} of 24  left/front_left, off its shoe")
            terminal.press("\n")
            terminal.until("reading: hold still")
            world.until(partial(fed, Load(0, "left/front_left", mass), f"{number + 1} of 24"))
        terminal.press("q")
        assert terminal.wait() == 1
        assert "stopped with 22 of 24 loads left" in terminal.seen
    entries = load_measurements(data, CELLS, shoe).entries
    assert [entry.load.mass for entry in entries] == [0.0, 1.0]
    assert 0 < entries[0].made_ns < entries[1].made_ns
