"""Messages of robots' drivers: the real packages where they are installed, else stand-ins."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from std_msgs.msg import Bool
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from core.sensing.shoes import ROOT
from ros.world import World
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import trajectory_to_ros

STAND_INS = ROOT / "build/stand_ins"
SCRIPT = Path(__file__).with_name("stand_in_robot.py")
PACKAGES = {
    "nao_lola": ("nao_lola_command_msgs", "nao_lola_sensor_msgs"),
    "naoqi": ("naoqi_bridge_msgs",),
    "action": ("control_msgs",),
    "slow_action": ("control_msgs",),
    "topic": (),
}

Begin = Callable[..., "Adapted"]


class Adapted:
    """A stand-in robot, an adapter, and what somebody who moves it says."""

    def __init__(
        self,
        world: World,
        kind: str,
        adapter: str,
        *,
        armed_by_test: bool = True,
        **parameters: object,
    ) -> None:
        self.world = world
        world.start("robot", {"kind": kind}, script=SCRIPT)
        world.start(adapter, parameters)
        if armed_by_test:
            self._armed = world.publisher(Bool, "shoe/armed", qos.ARMED)
            self._commands = world.publisher(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
        world.until_told(adapter, "robot", "not armed")

    def arm(self, armed: bool = True) -> None:
        self._armed.publish(Bool(data=armed))

    def send(self, trajectory: JointTrajectory) -> None:
        self._commands.publish(trajectory_to_ros(trajectory))


@pytest.fixture
def begin(world: World, monkeypatch: pytest.MonkeyPatch) -> Begin:
    """Starts a stand-in robot and its adapter, not armed."""

    def start(kind: str, adapter: str, **parameters: Any) -> Adapted:
        paths = {"PYTHONPATH": [ROOT / "test"], "LD_LIBRARY_PATH": []}
        if not all(importlib.util.find_spec(package) for package in PACKAGES[kind]):
            if not (STAND_INS / ".complete").is_file():
                pytest.skip("no messages of this driver, nor stand-ins; make stand-ins")
            library = STAND_INS / "install/lib"
            paths["PYTHONPATH"] += library.glob("python3.*/site-packages")
            paths["LD_LIBRARY_PATH"].append(library)
        for name, added in paths.items():
            rest = os.environ.get(name, "").split(os.pathsep)
            monkeypatch.setenv(name, os.pathsep.join([*map(str, added), *filter(None, rest)]))
        return Adapted(world, kind, adapter, **parameters)

    return start
