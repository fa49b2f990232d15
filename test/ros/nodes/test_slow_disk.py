"""A disk that takes its time holds no force up: what is put in force is saved beside it all."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import PointStamped
from rclpy.client import Client
from shoecal_msgs.srv import GetCalibration, SetCalibration
from std_srvs.srv import Trigger

from ros.bodies import calibration, nao, nao_shoe
from ros.standing_robot import StandingRobot
from ros.world import World
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import calibration_to_ros

SCRIPT = Path(__file__).with_name("slow_disk_calibrator.py")
SUPPORT = DoubleSupport(0.0, -0.112, 0.0)


class Calls:
    """Calls of a service."""

    def __init__(self, world: World, kind: type[Any], name: str) -> None:
        self._world = world
        self._client: Client = world.node.create_client(kind, name)
        world.until(self._client.service_is_ready)
        world.until_discovered_by("calibrator")

    def begin(self, request: Any) -> Any:
        return self._client.call_async(request)

    def answer(self, request: Any) -> Any:
        call = self.begin(request)
        self._world.until(call.done)
        return call.result()


def request(identity: str) -> SetCalibration.Request:
    made = calibration(nao(), nao_shoe(), identity)
    return SetCalibration.Request(calibration=calibration_to_ros(made))


def test_a_slow_disk_holds_up_no_force(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    slow, waiting = world.folder / "slow", world.folder / "slow.waiting"
    monkeypatch.setenv("SLOW_DISK", str(slow))
    StandingRobot(world, SUPPORT)
    folders = {name: world.folder / name for name in ("state_dir", "sessions_dir")}
    world.start("calibrator", folders, script=SCRIPT)
    change = Calls(world, SetCalibration, "shoe/set_calibration")
    rollback = Calls(world, Trigger, "shoe/rollback")
    get = Calls(world, GetCalibration, "shoe/get_calibration")
    for identity in ("one", "two"):
        assert change.answer(request(identity)).success
    cop = world.receive(PointStamped, "shoe/cop", qos.LIVE)
    for begin, target in (
        (lambda: change.begin(request("three")), "three"),
        (lambda: rollback.begin(Trigger.Request()), "two"),
    ):
        before = get.answer(GetCalibration.Request()).calibration.id
        waiting.unlink(missing_ok=True)
        slow.touch()
        changing = begin()
        world.until(waiting.exists)
        heard = len(cop)
        world.until(lambda: len(cop) > heard + 20)  # noqa: B023
        busy = change.answer(request("four"))
        assert (busy.success, busy.error_code) == (False, SetCalibration.Response.BUSY)
        assert "call again" in busy.message
        refused = rollback.answer(Trigger.Request())
        assert (refused.success, refused.message) == (False, busy.message)
        assert get.answer(GetCalibration.Request()).calibration.id == before
        assert not changing.done()
        slow.unlink()
        world.until(changing.done)
        assert changing.result().success
        assert get.answer(GetCalibration.Request()).calibration.id == target
