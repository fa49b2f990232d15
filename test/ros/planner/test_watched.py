from __future__ import annotations

from dataclasses import replace

import pytest
from sensor_msgs.msg import Imu, Temperature
from shoecal_msgs.msg import ShoeVoltages

from ros.bodies import nao
from ros.clock import Clock
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.common.codes import Code
from shoecal_ros.common.conversions import header_to_ros
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.inputs.imu import ImuInput
from shoecal_ros.inputs.shoe_reports import ShoeReports
from shoecal_ros.inputs.temperatures import TemperatureInput
from shoecal_ros.planner.settings import MovingSettings
from shoecal_ros.planner.watch import Senses
from shoecal_ros.planner.watched import watched

KINEMATICS = Kinematics(nao())
SUBJECTS = ("tilt", "shoes", "heat")


class Scene:
    """A robot whose sensors may tell something."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.senses = Senses(
            ImuInput(nao(), self.clock),
            ShoeReports(clock=self.clock),
            TemperatureInput(nao(), self.clock),
            KINEMATICS,
            MovingSettings(),
        )

    def tell(self, degc: float = 40.0) -> None:
        imu = Imu(header=header_to_ros(round(self.clock.now * 1e9), "base_link"))
        imu.orientation.w = 1.0
        self.senses.imu.take([imu])
        self.senses.shoes.take_readings([ShoeVoltages()])
        heat = Temperature(header=header_to_ros(1, "RKneePitch"), temperature=degc)
        self.senses.temperatures.take([heat])

    def conditions(self, *, joints: bool = True, required: bool = True) -> dict[str, Condition]:
        angles = nao().posture if joints else None
        settings = MovingSettings(tilt_required=required, load_required=required)
        return watched(replace(self.senses, settings=settings), angles)


@pytest.fixture
def scene() -> Scene:
    return Scene()


def test_what_never_came_but_must_is_told(scene: Scene) -> None:
    found = scene.conditions()
    assert [found[name].level for name in SUBJECTS] == [Level.WARN, Level.WARN, Level.OK]
    assert [found[name].code for name in SUBJECTS[:2]] == [Code.IMU_STALE, Code.SHOES_STALE]
    for name in SUBJECTS[:2]:
        assert "nothing moves" in found[name].message


def test_what_never_came_and_need_not_is_no_fault(scene: Scene) -> None:
    found = scene.conditions(required=False)
    assert tuple(found) == SUBJECTS
    assert all(one.level is Level.OK and "not watched" in one.message for one in found.values())


def test_what_comes_is_watched(scene: Scene) -> None:
    scene.tell()
    found = scene.conditions()
    assert all(one.level is Level.OK and "not" not in one.message for one in found.values())
    assert float(found["tilt"].values["offset_rad"]) < 0.2
    assert found["heat"].values == {"joint": "RKneePitch", "degc": "40.0"}
    assert scene.conditions(joints=False)["tilt"].message == "imu comes"


@pytest.mark.parametrize(
    ("after_s", "gone"), [(0.4, ()), (2.0, ("tilt", "shoes")), (11.0, SUBJECTS), (1e4, SUBJECTS)]
)
def test_what_came_and_comes_no_more_is_a_warning(
    scene: Scene, after_s: float, gone: tuple[str, ...]
) -> None:
    scene.tell()
    scene.clock.now += after_s
    found = scene.conditions()
    codes = {"tilt": Code.IMU_STALE, "shoes": Code.SHOES_STALE, "heat": Code.HEAT_STALE}
    for subject, condition in found.items():
        assert condition.level is (Level.WARN if subject in gone else Level.OK)
        assert condition.code == (codes[subject] if subject in gone else Code.OK)
        assert ("not watched; check" in condition.message) == (subject in gone)
    scene.tell()
    assert all(one.level is Level.OK for one in scene.conditions().values()), "back again"


def test_hot_motors_are_a_warning(scene: Scene) -> None:
    scene.tell(degc=90.0)
    heat = scene.conditions()["heat"]
    assert (heat.level, "'RKneePitch' is at 90 degC" in heat.message) == (Level.WARN, True)
    assert heat.code == Code.MOTOR_HOT
