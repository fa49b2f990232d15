from __future__ import annotations

import numpy as np
import pytest
from sensor_msgs.msg import JointState

from ros.bodies import nao
from ros.clock import Clock
from shoecal_ros.common.codes import Code
from shoecal_ros.common.conversions import header_to_ros
from shoecal_ros.common.voltage_frame import VoltageFrame
from shoecal_ros.inputs.joining import FrameJoiner
from shoecal_ros.inputs.joints import JointInput
from shoecal_ros.inputs.one_clock import OneClock
from shoecal_ros.inputs.voltages import VoltageInput

CELL = "left/a"
SECOND = 1_000_000_000


class Scene:
    """A robot and a shoe that tell something at the same time."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.joints = JointInput(nao(), 0.5, self.clock)
        self.voltages = VoltageInput(FrameJoiner((CELL,), 0.03, self.clock), 0.5)
        self.one_clock = OneClock(self.joints, self.voltages, 2.0, self.clock)
        self.step = 0

    def tell(self, seconds: float, gap_s: float = 0.0, *, joints_every: int = 1) -> None:
        """For a while, ten times a second; the shoe's stamps differ from the robot's.

        Joint angles come with one in so many of the frames of the shoe; 0: with none.
        """
        for _ in range(round(10.0 * seconds)):
            self.step += 1
            self.clock.now += 0.1
            stamp_ns = 100 * SECOND + self.step * SECOND // 10
            if joints_every and self.step % joints_every == 0:
                self._tell_joints(stamp_ns)
            shoe_ns = stamp_ns + round(gap_s * SECOND)
            status = np.zeros(1, dtype=np.uint8)
            reported = VoltageFrame(shoe_ns, "shoe", self.step, (CELL,), np.ones(1), status)
            self.voltages.take([reported])
            self.problem = self.one_clock.problem

    def _tell_joints(self, stamp_ns: int) -> None:
        robot = nao()
        names, angles = list(robot.joint_names), robot.posture.tolist()
        message = JointState(header=header_to_ros(stamp_ns, ""), name=names, position=angles)
        self.joints.take([message])


@pytest.mark.parametrize("gap_s", [-30.0, 3.0, 1e6])
def test_stamps_that_stay_apart_are_of_two_clocks(gap_s: float) -> None:
    scene = Scene()
    assert scene.one_clock.problem is None, "nothing has come"
    scene.tell(5.0)
    assert scene.problem is None
    scene.tell(1.9, gap_s)
    assert scene.problem is None, "one of both may be late for a while"
    scene.tell(0.4, gap_s)
    assert scene.problem is not None
    assert scene.problem.code == Code.CLOCKS_APART
    assert f"{abs(gap_s):.1f} s apart; let both senders use one clock" in scene.problem.message


def test_a_small_gap_or_a_short_one_is_none() -> None:
    scene = Scene()
    for _ in range(3):
        scene.tell(1.0, 1.5)
        assert scene.problem is None
        scene.tell(1.5, 3.0)
        assert scene.problem is None


def test_of_what_comes_no_more_nothing_is_compared() -> None:
    scene = Scene()
    scene.tell(1.0)
    scene.tell(10.0, joints_every=0)
    assert scene.problem is None


def test_a_pause_is_no_time_apart() -> None:
    scene = Scene()
    scene.tell(1.5, 3.0)
    scene.tell(5.0, 3.0, joints_every=0)
    scene.tell(1.9, 3.0)
    assert scene.problem is None
    scene.tell(0.4, 3.0)
    assert scene.problem is not None


def test_angles_that_come_seldom_are_compared_all_the_same() -> None:
    scene = Scene()
    scene.tell(5.0, 0.0, joints_every=7)
    scene.tell(3.5, 3.0, joints_every=7)
    assert scene.problem is not None
