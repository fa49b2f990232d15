from __future__ import annotations

import os
import pty
import time
import tty
from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import count
from pathlib import Path

import numpy as np
import pytest
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from shoecal_msgs.msg import ShoeVoltages

from ros.bodies import nao_shoe
from ros.world import Received, World
from shoecal_core.shoe.shoe import Shoe
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import time_from_ros, time_to_ros
from shoecal_ros.serial.device import SimulatedDevice
from shoecal_ros.serial.frame import Info
from shoecal_ros.simulator.device_file import write_device

INFO = Info("test", 1, 8, 100.0)
COUNTS = [1000 * index for index in range(8)]
BOOT_NS = time.monotonic_ns()


@pytest.fixture
def port(tmp_path: Path) -> Path:
    return tmp_path / "port"


@pytest.fixture
def device(port: Path) -> Iterator[SimulatedDevice]:
    with SimulatedDevice(port, INFO) as device:
        yield device


def send(world: World, device: SimulatedDevice, begin: int, frames: int) -> None:
    """Send frames, each until the driver listens."""
    for index in range(begin, begin + frames):
        world.until(partial(_send_one, device, index))


def _send_one(device: SimulatedDevice, sequence: int) -> bool:
    now_us = (time.monotonic_ns() - BOOT_NS) // 1000
    return device.send(sequence, now_us, COUNTS, [0] * 8, temperature=21.5)


def connect(world: World, device: SimulatedDevice, heard: Received) -> int:
    """Send frames until messages come: the first ones have no subscriber; the next sequence."""
    sequence = count()

    def heard_of() -> bool:
        _send_one(device, next(sequence))
        return len(heard) > 0

    world.until(heard_of)
    return next(sequence)


def _reported(world: World) -> dict[str, str]:
    status = world.diagnosis("shoe_driver", "device")
    return {} if status is None else {pair.key: pair.value for pair in status.values}


def test_every_frame_becomes_a_message(world: World, device: SimulatedDevice, port: Path) -> None:
    world.start("shoe_driver", {"port": port})
    voltages = world.receive(ShoeVoltages, "shoe/voltages")
    begin = connect(world, device, voltages)
    send(world, device, begin, 50)
    world.until(lambda: voltages.last.sequence == begin + 49)
    assert [one.sequence for one in voltages.messages[-50:]] == list(range(begin, begin + 50))
    last = voltages.last
    assert tuple(last.cell) == nao_shoe().names
    np.testing.assert_allclose(last.voltage, np.array(COUNTS) * 10.0 / 2**24)
    assert list(last.status) == [0] * 8
    assert last.temperature == pytest.approx(21.5)
    assert last.header.frame_id == "shoe_driver"
    stamps = [one.header.stamp.sec + 1e-9 * one.header.stamp.nanosec for one in voltages.messages]
    assert np.all(np.diff(stamps) > 0.0)
    world.until_reported("shoe_driver", "device", "reading")
    # The first of its diagnostics may be older than what the device says of itself.
    world.until(lambda: _reported(world).get("firmware") == "test")


def test_a_simulated_device_and_the_host_share_simulated_time(
    world: World, device: SimulatedDevice, port: Path
) -> None:
    world.start("shoe_driver", {"port": port, "use_sim_time": True})
    voltages = world.receive(ShoeVoltages, "shoe/voltages")
    clock = world.publisher(Clock, "/clock", qos.CLOCK)
    sequence = count(100)

    def heard_of() -> bool:
        index = next(sequence)
        # The clock ticks in coarse steps, ahead of what was sampled.
        tick = (index + 5 - index % 5) * 10**7
        clock.publish(Clock(clock=time_to_ros(tick)))
        world.until(lambda: device.send(index, 10_000 * index, COUNTS, [0] * 8))
        return len(voltages) >= 20

    world.until(heard_of)
    last = voltages.last
    assert time_from_ros(last.header.stamp) == last.sequence * 10**7


def test_unplugging_and_plugging_again(world: World, device: SimulatedDevice, port: Path) -> None:
    world.start("shoe_driver", {"port": port})
    voltages = world.receive(ShoeVoltages, "shoe/voltages")
    begin = connect(world, device, voltages)
    device.unplug()
    world.until_reported("shoe_driver", "device", "plug the device in")
    device.plug()
    sequence = count(begin)

    def heard_again() -> bool:
        _send_one(device, next(sequence))
        return bool(voltages.last.sequence >= begin)

    world.until(heard_again)


def test_a_port_that_is_not_there(world: World, port: Path) -> None:
    world.start("shoe_driver", {"port": port})
    status = world.until_reported("shoe_driver", "device", "does not exist")
    assert status.level == b"\x02"
    assert str(port) in status.message


def test_no_peer_changes_its_clock(world: World, port: Path) -> None:
    world.start("shoe_driver", {"port": port})
    wanted = [Parameter("use_sim_time", value=True).to_parameter_msg()]
    request = SetParameters.Request(parameters=wanted)
    (result,) = world.call(SetParameters, "shoe_driver/set_parameters", request).results
    assert not result.successful
    assert "use_sim_time: parameters stay while a node runs" in result.reason


def test_a_port_that_sends_nothing(
    world: World, device: SimulatedDevice, port: Path, tmp_path: Path
) -> None:
    world.start("shoe_driver", {"port": port})
    world.until_reported("shoe_driver", "device", "check the device's power and cable")


def test_a_port_that_sends_garbage(world: World, port: Path) -> None:
    line, end = pty.openpty()
    tty.setraw(end)
    port.symlink_to(os.ttyname(end))
    world.start("shoe_driver", {"port": port})
    rng = np.random.default_rng(1)

    def reported() -> bool:
        os.write(line, rng.bytes(50))
        status = world.diagnosis("shoe_driver", "device")
        return status is not None and "no good frame" in status.message

    world.until(reported)
    assert "'baud'" in world.diagnosis("shoe_driver", "device").message
    os.close(line)
    os.close(end)


def test_two_sources_of_one_cell(world: World, device: SimulatedDevice, port: Path) -> None:
    world.start("shoe_driver", {"port": port})
    sequence = count(connect(world, device, world.receive(ShoeVoltages, "shoe/voltages")))
    rival = world.publisher(ShoeVoltages, "shoe/voltages")
    other = ShoeVoltages(cell=["left/rear_left"], voltage=[1.0], status=[0])
    # Any peer may send any name.
    other.header.frame_id = "rival\n" + 5000 * "x"
    other.header.stamp.sec = 7

    def reported() -> bool:
        rival.publish(other)
        status = world.diagnosis("shoe_driver", "device")
        return status is not None and "also come from 'rival xxx" in status.message

    world.until(reported)
    message = world.diagnosis("shoe_driver", "device").message
    assert "left/rear_left" in message
    assert len(message) < 300

    def well_again() -> bool:
        _send_one(device, next(sequence))
        return bool(world.diagnosis("shoe_driver", "device").message.startswith("reading"))

    # The rival stays on the topic, and sends nothing more.
    world.until(well_again)


def _one_foot(foot: str) -> Shoe:
    channels = nao_shoe().channels
    own = tuple(channel for channel in channels if channel.name.startswith(f"{foot}/"))
    return replace(nao_shoe(), channels=own)


def test_boards_of_one_foot_each_do_not_disturb_each_other(world: World, tmp_path: Path) -> None:
    names = nao_shoe().names
    heard = world.receive(ShoeVoltages, "shoe/voltages")
    with (
        SimulatedDevice(tmp_path / "left", INFO) as left,
        SimulatedDevice(tmp_path / "right", INFO) as right,
    ):
        for foot in ("left", "right"):
            write_device(tmp_path / f"{foot}.yaml", _one_foot(foot), tmp_path / foot, 24)
        for foot in ("left", "right"):
            world.start(
                "shoe_driver", {"config_file": tmp_path / f"{foot}.yaml"},
                "-r", f"__node:={foot}_driver", name=f"{foot}_driver",
            )  # fmt: skip
        world.until(lambda: world.node.count_publishers("shoe/voltages") == 2)
        sequence = count()

        def both_heard() -> bool:
            index = next(sequence)
            send(world, left, index, 1)
            send(world, right, index, 1)
            return len({one.header.frame_id for one in heard.messages}) == 2

        world.until(both_heard)
    cells = {one.header.frame_id: tuple(one.cell) for one in heard.messages}
    assert cells == {"left_driver": names[:4], "right_driver": names[4:]}
    for foot in ("left", "right"):
        status = world.diagnosis(f"{foot}_driver", "device")
        assert status is None or "also come" not in status.message


def test_a_device_file_that_cannot_be_used_ends_the_node(world: World, tmp_path: Path) -> None:
    file = tmp_path / "device.yaml"
    file.write_text("format: 1\nport: /dev/null\nbaud: fast\n")
    world.start("shoe_driver", {"config_file": file})
    assert world.ended("shoe_driver") == 1
    assert str(file) in world.output("shoe_driver")
