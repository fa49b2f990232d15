from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from numpy.typing import NDArray
from rclpy.publisher import Publisher
from std_msgs.msg import Bool
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from ros.bodies import nao
from ros.clock import Clock
from shoecal_ros.calibrator.halt import Halt
from shoecal_ros.common.conversions import trajectory_from_ros
from shoecal_ros.common.health import Level
from shoecal_ros.common.hold import STOP_TIME_S
from shoecal_ros.inputs.armed_input import LEASE_S, ArmedInput
from shoecal_ros.inputs.joints import JointBatch, JointInput

FloatArray = NDArray[np.float64]
POSTURE = nao().posture
KNEE = nao().joint("LKneePitch")


class Scene:
    """A planner, a calibrator's halt, and the commands that it sends."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.robot = nao()
        self.joints = JointInput(nao(), 0.5, self.clock)
        self.run_id = ""
        self.planners = 1
        self.offered = 0
        self.sent: list[JointTrajectoryMsg] = []
        self.logged: list[str] = []
        self.arming = ArmedInput(self, self.clock)  # type: ignore[arg-type]
        self.halt = Halt(self, self.arming)  # type: ignore[arg-type]
        for _ in range(10):
            self.receive(POSTURE)

    # Of a node

    def subscribe(self, *_: object) -> Any:
        return SimpleNamespace(get_publisher_count=lambda: self.planners)

    def create_publisher(self, *_: object) -> Publisher:
        self.offered += 1
        return cast(Publisher, SimpleNamespace(publish=self.sent.append))

    def destroy_publisher(self, _: Publisher) -> bool:
        self.offered -= 1
        return True

    def log(self, level: Level, line: str) -> None:
        assert level is Level.ERROR
        self.logged.append(line)

    # Of the robot and its planner

    def receive(self, angles: FloatArray) -> None:
        self.joints.heard.note()
        self.halt.receive(JointBatch(np.array([1]), angles[None]))

    def arm(self, armed: bool = True) -> None:
        self.arming._hear([Bool(data=armed)])
        self.halt.watch()

    def go_on(self, seconds: float, *, armed: bool = False) -> None:
        for _ in range(round(seconds / 0.1)):
            self.clock.now += 0.1
            if armed:
                self.arming._hear([Bool(data=True)])
            self.halt.watch()

    @property
    def held(self) -> FloatArray:
        """(m,) [rad]."""
        angles: FloatArray = trajectory_from_ros(self.sent[-1]).full(nao(), POSTURE).positions[-1]
        return angles


@pytest.fixture
def scene() -> Scene:
    return Scene()


def test_nothing_is_sent_while_the_planner_is_there(scene: Scene) -> None:
    scene.go_on(1.0)
    assert scene.offered == 0, "commands are left to the planner alone"
    scene.arm()
    scene.go_on(5.0, armed=True)
    assert scene.offered == 1, "known to the robot before it is needed"
    scene.arm(False)
    scene.go_on(5.0)
    assert scene.sent == []
    assert scene.offered == 0


def test_a_planner_that_falls_silent_is_noticed_within_its_lease(scene: Scene) -> None:
    scene.run_id = "20261122T101500123"
    scene.arm()
    scene.go_on(5.0, armed=True)
    scene.go_on(LEASE_S - 0.2)
    assert scene.sent == []
    scene.run_id = ""
    scene.clock.now += 0.3
    scene.go_on(10.0)
    assert len(scene.sent) == 1
    assert scene.held == pytest.approx(POSTURE)
    assert "20261122T101500123" in scene.logged[0], "though its job ended at the same moment"
    assert scene.offered == 1, "it may still be on its way"


def test_a_planner_whose_end_the_middleware_tells_is_noticed_at_once(scene: Scene) -> None:
    scene.arm()
    scene.go_on(5.0, armed=True)
    scene.planners = 0
    scene.halt.watch()
    assert not scene.arming.armed
    assert len(scene.sent) == 1
    scene.go_on(10.0)
    assert len(scene.sent) == 1
    assert scene.offered == 1
    scene.planners = 1
    scene.arm()
    assert len(scene.sent) == 1, "another planner is there"
    scene.planners = 0
    scene.halt.watch()
    assert len(scene.sent) == 2, "and stops the robot for the next one, too"


def test_a_planner_that_was_started_anew_knows_of_no_motion(scene: Scene) -> None:
    scene.arm()
    scene.go_on(5.0, armed=True)
    scene.go_on(1.0)
    scene.arm(False)
    assert len(scene.sent) == 1
    scene.go_on(10.0)
    scene.arm(False)
    assert len(scene.sent) == 1
    scene.arm()
    scene.arm(False)
    assert (len(scene.sent), scene.offered) == (1, 0)


@pytest.mark.parametrize("false", [1, 2])
def test_one_false_message_or_two_do_not_move_it(scene: Scene, false: int) -> None:
    scene.arm()
    angles = POSTURE.copy()
    angles[KNEE] += 0.8
    for _ in range(false):
        scene.receive(angles)
    scene.planners = 0
    scene.halt.watch()
    assert scene.held == pytest.approx(POSTURE)


def test_it_does_not_hurry_back_to_where_the_robot_was_long_ago(scene: Scene) -> None:
    scene.arm()
    scene.go_on(3.0, armed=True)
    scene.planners = 0
    scene.halt.watch()
    assert trajectory_from_ros(scene.sent[0]).duration == pytest.approx(STOP_TIME_S + 3.0)


def test_who_has_told_no_joint_angles_is_not_commanded() -> None:
    scene = Scene()
    scene.halt = Halt(scene, scene.arming)  # type: ignore[arg-type]
    scene.arm()
    scene.planners = 0
    scene.halt.watch()
    assert scene.sent == []
    scene.receive(POSTURE)
    scene.halt.watch()
    assert len(scene.sent) == 1
