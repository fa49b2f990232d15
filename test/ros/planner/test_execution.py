from __future__ import annotations

import math
import time
from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from shoecal_msgs.action import Plan

from ros.bodies import nao
from ros.clock import Clock
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.horizon.rolling import Path
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.motion import Motion, Phase
from shoecal_core.planning.posture import stance
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.common.awake_clock import CATCH_UP_S, AwakeClock
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.renewal import TIMEOUT_S
from shoecal_ros.inputs.imu import ImuInput
from shoecal_ros.inputs.joints import JointBatch
from shoecal_ros.inputs.robot_time import RobotTime
from shoecal_ros.inputs.shoe_reports import ShoeReports
from shoecal_ros.inputs.temperatures import TemperatureInput
from shoecal_ros.planner.arming import Arming
from shoecal_ros.planner.execution import Execution
from shoecal_ros.planner.order import Mover, Order
from shoecal_ros.planner.settings import MovingSettings
from shoecal_ros.planner.watch import Senses

SUPPORT = DoubleSupport(0.0, -0.11, 0.0)
ANGLES = nao().from_legs(stance(nao(), SUPPORT))
KNEE = nao().joint("LKneePitch")
PERIOD_S = 0.01


def standing() -> Motion:
    """A motion in which nothing moves, 1 s long."""
    time = np.linspace(0.0, 1.0, 51)
    positions = np.tile(ANGLES, (len(time), 1))
    pose, none = FootPose.of(SUPPORT), np.zeros(0)
    path = Path(
        np.zeros((1, len(nao().legs))), np.zeros((0, 2)), none, none.astype(np.int64), (), none
    )
    return Motion(
        "standing", SUPPORT, pose, nao().joint_names, time, positions, np.zeros_like(positions),
        np.tile([0.0, -0.055], (len(time), 1)), path,
        (Phase("both", SupportPhase.BOTH, 0.0, 1.0, (pose, pose)),),
    )  # fmt: skip


class Scene:
    """An armed robot that has just been sent a motion, and an execution that watches it."""

    def __init__(self, slept_s: float = 0.0) -> None:
        self.clock = clock = Clock()
        moving = MovingSettings(tilt_required=False, load_required=False)
        self.sent: list[JointTrajectory] = []
        self.arming = Arming(10.0, clock)
        self.arming.set(True)
        self.told_s = 0.0
        self.slept_s = 0.0
        self.sleeps_s = {"before": 0.0, "within": 0.0}
        self.listeners = SimpleNamespace(missing="", look=lambda: None)
        self._joints = SimpleNamespace(latest=self._batch(ANGLES), problem=None)
        self.mover = cast(
            Mover,
            SimpleNamespace(
                robot=nao(),
                kinematics=Kinematics(nao()),
                planning=PlannerSettings(),
                moving=moving,
                arming=self.arming,
                joints=self._joints,
                listeners=self.listeners,
                senses=Senses(
                    ImuInput(nao(), clock),
                    ShoeReports(clock=clock),
                    TemperatureInput(nao(), clock),
                    Kinematics(nao()),
                    moving,
                ),
                robot_time=RobotTime(simulated=False),
                awake=AwakeClock(clock),
                command=self._command,
            ),
        )
        self.order = Order(True, lambda: False, lambda *_: None)
        self.execution = Execution(self.mover, self.order)
        self.execution.check_ready()
        motion = standing()
        clock.now += slept_s
        self._following = self.execution.follow(self.execution.commanded(motion), motion)
        self._following.send(None)
        assert self.execution.following
        assert len(self.sent) == (0 if slept_s else 1)

    def tell(self, angles: FloatArray, times: int = 1, *, stamp_ns: int | None = None) -> None:
        """Joint angles come, of the next period or of another time."""
        for _ in range(times):
            self.told_s += PERIOD_S
            self._joints.latest = self._batch(angles, stamp_ns)
            self._following.send(None)

    def fall_silent(self) -> None:
        self._joints.problem = Problem(Code.JOINTS_STALE, "no joint angles for 1 s")
        self._following.send(None)

    def look(self) -> None:
        self._following.send(None)

    def _command(
        self, trajectory: JointTrajectory, _stamp_ns: int = 0, not_after: float = math.inf
    ) -> bool:
        self.slept_s += self.sleeps_s["before"]
        if time.monotonic() + self.slept_s > not_after:
            return False
        self.slept_s += self.sleeps_s["within"]
        self.sent.append(trajectory)
        return True

    @property
    def ways(self) -> FloatArray:
        """(k,) by which the stop moves joints from where they were to be [rad]."""
        assert [len(one.times) == 1 for one in self.sent].count(True) == 1, "one command to stop"
        ways: FloatArray = np.abs(self.sent[-1].positions[0] - ANGLES[nao().moved])
        return ways

    def _batch(self, angles: FloatArray, stamp_ns: int | None = None) -> JointBatch:
        at_ns = 1 + round(self.told_s * 1e9) if stamp_ns is None else stamp_ns
        return JointBatch(np.array([at_ns]), angles[None])


@pytest.fixture
def scene() -> Scene:
    return Scene()


def off(way: float) -> FloatArray:
    """The knee is so much off."""
    angles = ANGLES.copy()
    angles[KNEE] += way
    return angles


@pytest.mark.parametrize(
    ("required", "missing"),
    [({"load_required": False}, "imu"), ({"tilt_required": False}, "shoe/voltages")],
)
def test_nothing_begins_that_nobody_would_watch(
    scene: Scene, required: dict[str, Any], missing: str
) -> None:
    settings = MovingSettings(**required)
    scene.mover.senses = replace(scene.mover.senses, settings=settings)
    with pytest.raises(RefusedError, match=f"nothing comes from {missing}.*_required") as caught:
        Execution(scene.mover, scene.order).check_ready()
    assert caught.value.code == Plan.Result.SENSORS_STALE


def test_who_disarms_and_arms_at_once_stops_the_robot_for_good(scene: Scene) -> None:
    scene.arming.set(False)
    scene.arming.set(True)
    with pytest.raises(RefusedError, match="disarmed since") as refusal:
        scene.look()
    assert refusal.value.code == Plan.Result.NOT_ARMED
    assert not scene.execution.following
    np.testing.assert_allclose(scene.ways, 0.0, atol=1e-9)
    with pytest.raises(RefusedError, match="disarmed since"):
        scene.execution.check_ready()
    Execution(scene.mover, scene.order).check_ready()


def test_what_is_ended_holds_a_moving_robot_on_its_way_once(scene: Scene) -> None:
    """Not where it was measured: motors give, and held there it would sink farther."""
    scene.tell(off(0.05))
    scene.execution.halt()
    scene.execution.halt()
    assert scene.ways.max() < 1e-9
    sent = len(scene.sent)
    Execution(scene.mover, scene.order).halt()
    assert len(scene.sent) == sent, "nothing to stop"


def test_it_is_sent_in_pieces_while_it_goes_well(scene: Scene) -> None:
    scene.tell(ANGLES, 35)
    assert len(scene.sent) == 4
    assert max(piece.duration for piece in scene.sent) <= TIMEOUT_S


def test_nothing_is_sent_in_doubt(scene: Scene) -> None:
    scene.tell(ANGLES, 8)
    scene.tell(off(0.3), 2)
    assert len(scene.sent) == 1
    scene.tell(ANGLES)
    assert len(scene.sent) == 2


def test_who_was_held_up_for_a_moment_goes_on(scene: Scene) -> None:
    scene.told_s += 0.8
    scene.tell(ANGLES)
    assert len(scene.sent) == 2


def test_after_a_sleep_nothing_is_sent_before_what_waited_is_heard(scene: Scene) -> None:
    sent = len(scene.sent)
    scene.clock.now += 0.4
    # Joint angles of just after it fell asleep.
    scene.tell(ANGLES, 12)
    assert len(scene.sent) == sent
    for _ in range(4):
        scene.clock.now += 0.23 * CATCH_UP_S
        scene.tell(ANGLES)
        assert len(scene.sent) == sent
    scene.clock.now += 0.23 * CATCH_UP_S
    scene.tell(ANGLES)
    assert len(scene.sent) == sent + 1


def test_a_motion_that_begins_after_a_sleep_waits_for_its_first_piece() -> None:
    scene = Scene(slept_s=0.4)
    for _ in range(5):
        scene.tell(ANGLES, 5)
        assert not scene.sent
        scene.clock.now += 0.23 * CATCH_UP_S
    scene.tell(ANGLES)
    assert len(scene.sent) == 1
    assert scene.execution.following


def test_joint_angles_may_be_as_late_as_the_settings_say(scene: Scene) -> None:
    scene.mover.moving = replace(scene.mover.moving, stale_s=3.0)
    scene.told_s += 3.0
    scene.tell(ANGLES)
    assert len(scene.sent) == 2
    assert scene.execution.following


def test_who_was_held_up_for_long_ends_the_motion_and_commands_no_way(scene: Scene) -> None:
    scene.told_s += 3.0
    with pytest.raises(RefusedError, match=r"held up for 3\.0 s.*ask for the motion again"):
        scene.tell(ANGLES)
    assert len(scene.sent) == 1, "it rests, and may have been moved meanwhile"
    assert not scene.execution.following


def test_a_clock_that_is_set_back_ends_the_motion_and_commands_no_way(scene: Scene) -> None:
    scene.tell(ANGLES, 20)
    sent = len(scene.sent)
    scene.told_s -= 3.0
    with pytest.raises(RefusedError, match="joint_states went back by"):
        scene.tell(ANGLES)
    assert len(scene.sent) == sent
    assert not scene.execution.following


ZEROS = np.clip(np.zeros(len(ANGLES)), nao().lower, nao().upper)
"""As another node tells them that knows no robot."""


@pytest.mark.parametrize("false", [off(0.8), ZEROS], ids=["one encoder", "another sender"])
def test_one_false_message_stops_nothing(scene: Scene, false: FloatArray) -> None:
    for _ in range(10):
        scene.tell(false, 2)
        scene.tell(off(0.01))
    assert scene.execution.following
    assert min(len(piece.times) for piece in scene.sent) > 1, "pieces alone"


@pytest.mark.parametrize("false", [off(0.8), ZEROS], ids=["one encoder", "another sender"])
def test_what_stays_false_stops_the_robot_where_it_was_seen(
    scene: Scene, false: FloatArray
) -> None:
    scene.tell(off(0.01))
    with pytest.raises(RefusedError, match="off its trajectory") as refusal:
        scene.tell(false, 3)
    assert refusal.value.code == Plan.Result.NOT_FOLLOWED
    bound = scene.mover.moving.follow_error
    assert scene.ways.max() == pytest.approx(bound), "no joint moves farther to stop"


def test_a_stop_for_another_cause_believes_no_single_message_either(scene: Scene) -> None:
    scene.tell(off(0.01))
    scene.tell(ZEROS, stamp_ns=1)
    with pytest.raises(RefusedError, match="no joint angles"):
        scene.fall_silent()
    assert scene.ways.max() < 0.02
    other = Scene()
    other.tell(ZEROS)
    other.arming.set(False)
    with pytest.raises(RefusedError, match="not armed"):
        other.look()
    assert other.ways.max() < 1e-9


@pytest.mark.parametrize("when", ["before", "within"])
def test_a_piece_that_a_sleep_kept_back_is_not_followed(
    scene: Scene, monkeypatch: pytest.MonkeyPatch, when: str
) -> None:
    """It would begin where the robot was before; the next one begins where it has come to."""
    clock = SimpleNamespace(monotonic=lambda: time.monotonic() + scene.slept_s)
    monkeypatch.setattr("shoecal_ros.planner.execution.time", clock)
    scene.sleeps_s[when] = 0.6
    scene.tell(ANGLES, 11)
    sent = len(scene.sent)
    assert sent == (1 if when == "before" else 3), "tried with all new joint angles"
    scene.sleeps_s[when] = 0.0
    scene.tell(ANGLES, 5)
    assert len(scene.sent) == sent + 1


def test_nothing_is_sent_to_nobody(scene: Scene) -> None:
    scene.listeners.missing = "nobody listens"
    with pytest.raises(RefusedError, match="stopped: nobody listens") as refusal:
        scene.tell(off(0.01))
    assert refusal.value.code == Plan.Result.NOT_FOLLOWED
    assert scene.ways.max() < 1e-9
    with pytest.raises(RefusedError, match="not begun: nobody listens"):
        scene.execution.check_ready()


def test_a_robot_that_is_blocked_is_stopped_within_a_tenth_of_a_second(scene: Scene) -> None:
    with pytest.raises(RefusedError, match=r"'LKneePitch' is 0\.150 rad off"):
        scene.tell(off(0.15), 10)
    assert scene.told_s < 0.1
