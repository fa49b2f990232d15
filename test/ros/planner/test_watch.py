from __future__ import annotations

import math

import numpy as np
import pytest
from sensor_msgs.msg import Imu, Temperature
from shoecal_msgs.action import Plan
from shoecal_msgs.msg import FootState, ShoeState, ShoeVoltages

from ros.bodies import nao
from ros.clock import Clock
from shoecal_core.planning.horizon.rolling import Path
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.motion import Motion, Phase
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.common.conversions import header_to_ros
from shoecal_ros.inputs.imu import ImuInput
from shoecal_ros.inputs.shoe_reports import ShoeReports
from shoecal_ros.inputs.temperatures import TemperatureInput
from shoecal_ros.planner.settings import MovingSettings
from shoecal_ros.planner.stop_reason import StopReason
from shoecal_ros.planner.watch import MotionWatch, Senses, needed_loads

KINEMATICS = Kinematics(nao())
SETTINGS = MovingSettings()
POSE = FootPose.of(DoubleSupport(0.0, -0.12, 0.0))
ANGLES = nao().posture


def motion() -> Motion:
    """The CoP goes over the left foot, the right one is in the air for a while, and back."""
    time = np.linspace(0.0, 9.0, 451)
    over_left = np.clip(np.minimum(time, 9.0 - time) / 3.0, 0.0, 1.0)
    cop = np.column_stack([np.full(len(time), 0.02), -0.06 * (1.0 - over_left)])
    spans = (
        (SupportPhase.BOTH, 0.0, 3.0),
        (SupportPhase.LEFT, 3.0, 6.0),
        (SupportPhase.BOTH, 6.0, 9.0),
    )
    positions = np.tile(ANGLES, (len(time), 1))
    return Motion(
        "made up", POSE.support, POSE, nao().joint_names, time, positions,
        np.zeros_like(positions), cop, _path(),
        tuple(Phase(str(feet), feet, begin, end, (POSE, POSE)) for feet, begin, end in spans),
    )  # fmt: skip


def _path() -> Path:
    none = np.zeros(0)
    states = np.zeros((1, len(nao().legs)))
    return Path(states, np.zeros((0, 2)), none, none.astype(np.int64), (), none)


class Watched:
    """A robot that stands, and a watch that has just begun."""

    def __init__(self, *, silent: bool = False) -> None:
        self.clock = Clock()
        self.senses = Senses(
            ImuInput(nao(), self.clock),
            ShoeReports(clock=self.clock),
            TemperatureInput(nao(), self.clock),
            KINEMATICS,
            SETTINGS,
        )
        if not silent:
            self.tell()
        self.watch = MotionWatch(self.senses, ANGLES)
        self.watch.begin(motion())

    def tell(
        self, pitch: float = 0.0, degc: float = 40.0, loaded: tuple[bool, bool] = (True, True)
    ) -> None:
        imu = Imu(header=header_to_ros(round(self.clock.now * 1e9), "base_link"))
        imu.orientation.y, imu.orientation.w = math.sin(pitch / 2.0), math.cos(pitch / 2.0)
        self.senses.imu.take([imu])
        self.senses.shoes.take_readings([ShoeVoltages()])
        feet = [
            FootState(foot=foot, loaded=load, valid=True)
            for foot, load in zip(("left", "right"), loaded, strict=True)
        ]
        self.senses.shoes.take_states([ShoeState(feet=feet)])
        header = header_to_ros(0, "LKneePitch")
        self.senses.temperatures.take([Temperature(header=header, temperature=degc)])

    def look(self, elapsed: float) -> StopReason | None:
        return self.watch.look(elapsed, ANGLES)


def test_which_feet_carry() -> None:
    watch = Watched().watch
    reported = [watch.support_phase(time).value for time in (0.0, 2.9, 3.1, 5.9, 6.1, 8.9, 99.0)]
    assert reported == ["both", "both", "left", "left", "both", "both", "both"]


def test_both_feet_carry_once_a_late_robot_has_put_its_foot_down() -> None:
    watch, late = Watched().watch, SETTINGS.follow_late
    reported = [
        watch.both_carry(time) for time in (0.0, 2.9, 3.1, 5.9, 6.1, 5.9 + late, 6.1 + late)
    ]
    assert reported == [True, True, False, False, False, False, True]
    assert watch.both_carry(99.0)


def test_loads_by_statics() -> None:
    needed = needed_loads(motion(), KINEMATICS)
    time = motion().time
    on_left = (time > 3.0) & (time < 6.0)
    assert needed[on_left] == pytest.approx(np.tile([nao().weight, 0.0], (on_left.sum(), 1)))
    assert needed.min() >= 0.0
    assert needed.sum(axis=1).max() <= nao().weight + 1e-9
    assert needed[0] == pytest.approx(needed[-1])


def test_a_healthy_motion_raises_no_concern() -> None:
    watched = Watched()
    for elapsed in np.arange(0.0, 10.0, 0.1):
        watched.clock.now += 0.1
        watched.tell(loaded=(True, not 3.0 < elapsed < 6.0))
        assert watched.look(float(elapsed)) is None


@pytest.mark.parametrize(
    ("reported", "code", "can_wait", "words"),
    [
        ({"pitch": 0.15}, Plan.Result.TILTED, False, "leans 0.15 rad"),
        ({"degc": 70.0}, Plan.Result.HOT_JOINTS, True, "'LKneePitch' is at 70 degC"),
        ({"loaded": (False, True)}, Plan.Result.LOAD_LOST, False, "the left foot"),
        ({"pitch": 0.15, "degc": 70.0}, Plan.Result.TILTED, False, "leans"),
    ],
)
def test_each_cause(reported: dict[str, object], code: int, can_wait: bool, words: str) -> None:
    watched = Watched()
    watched.tell(**reported)  # type: ignore[arg-type]
    reason = None
    for elapsed in (4.5, 5.0):
        reason = watched.look(elapsed)
    assert reason is not None
    assert (reason.code, reason.can_wait) == (code, can_wait)
    assert words in reason.message


def test_silence_can_wait() -> None:
    watched = Watched()
    watched.clock.now += SETTINGS.stale_s + 0.1
    reason = watched.look(1.0)
    assert reason is not None
    assert (reason.code, reason.can_wait) == (Plan.Result.SENSORS_STALE, True)
    assert "imu (0.6 s), shoe/voltages (0.6 s)" in reason.message


def test_motors_that_tell_their_temperature_no_more() -> None:
    watched = Watched()
    for _ in range(round(SETTINGS.heat_stale_s)):
        watched.clock.now += 1.0
        watched.tell(degc=math.nan)
        assert watched.look(1.0) is None
    watched.clock.now += 0.1
    reason = watched.look(1.0)
    assert reason is not None
    assert (reason.code, reason.can_wait) == (Plan.Result.SENSORS_STALE, True)
    assert "the temperature of 'LKneePitch' (10.1 s)" in reason.message


def test_who_never_told_anything_is_not_missed() -> None:
    watched = Watched(silent=True)
    watched.clock.now += 60.0
    assert watched.look(1.0) is None
