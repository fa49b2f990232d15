from __future__ import annotations

import numpy as np
import pytest
from sensor_msgs.msg import JointState

from ros.bodies import nao
from ros.clock import Clock
from shoecal_ros.common.conversions import JointSample, joints_to_ros
from shoecal_ros.inputs.joints import JointInput


def message(stamp_ns: int, changes: dict[str, float] | None = None) -> JointState:
    robot = nao()
    angles = robot.posture.copy()
    for name, angle in (changes or {}).items():
        angles[robot.joint(name)] = angle
    return joints_to_ros(JointSample(stamp_ns, robot.joint_names, angles))


def test_batches_come_in_the_robots_order() -> None:
    joints = JointInput(nao(), 0.5)
    shuffled = message(20, {"LKneePitch": 0.9})
    order = np.random.default_rng(1).permutation(len(shuffled.name))
    shuffled.name, shuffled.position = (
        [shuffled.name[index] for index in order],
        [shuffled.position[index] for index in order],
    )
    batch = joints.take([message(10), message(15), shuffled])
    assert batch is not None
    assert batch.stamp_ns.tolist() == [10, 15, 20]
    expected = np.tile(nao().posture, (3, 1))
    expected[2, nao().joint("LKneePitch")] = 0.9
    np.testing.assert_array_equal(batch.angles, expected)
    assert joints.latest is not None
    assert joints.latest.stamp_ns.tolist() == [20]


def test_what_is_wrong_is_told_in_turn() -> None:
    clock = Clock()
    joints = JointInput(nao(), 0.5, clock)
    assert "no joint angles yet" in joints.problem
    joints.take([message(10)])
    assert joints.problem == ""
    clock.now += 3.0
    assert joints.problem.startswith("no joint angles for 3 s")
    assert not joints.fresh
    assert joints.take([JointState(name=["elbow"], position=[0.0])]) is None
    assert "needs joint(s) HeadYaw" in joints.problem
    assert "elbow" in joints.problem
    joints.take([message(20)])
    assert joints.problem == ""


@pytest.mark.parametrize(
    ("broken", "problem"),
    [
        (JointState(name=["a", "b"], position=[0.0]), "1 positions for 2 names"),
        (message(10, {"LKneePitch": float("nan")}), "no number for joint.*LKneePitch"),
    ],
)
def test_numbers_that_cannot_be_used(broken: JointState, problem: str) -> None:
    joints = JointInput(nao(), 0.5)
    assert joints.take([broken]) is None
    with pytest.raises(AssertionError, match=problem):
        raise AssertionError(joints.problem)


@pytest.mark.parametrize(
    ("broken", "problem"),
    [
        (message(20, {"LKneePitch": float("nan")}), "no number for joint"),
        (JointState(name=["elbow"], position=[0.0]), "needs joint(s) HeadYaw"),
        (message(0), "no stamps"),
    ],
)
def test_a_message_that_cannot_be_used_is_no_news(broken: JointState, problem: str) -> None:
    clock = Clock()
    joints = JointInput(nao(), 0.5, clock)
    good = joints.take([message(10)])
    clock.now += 0.4
    assert joints.take([broken]) is None
    assert joints.problem == ""
    assert good is not None
    assert joints.latest is not None
    assert joints.latest.stamp_ns.tolist() == good.stamp_ns.tolist()
    clock.now += 0.2
    assert problem in joints.problem
    joints.take([message(30)])
    assert joints.problem == ""


def test_an_optional_joint_may_tell_nothing() -> None:
    joints = JointInput(nao(), 0.5)
    assert joints.take([message(10, {"LHand": float("nan")})]) is not None
    assert joints.problem == ""


def test_stamps_that_stand_still_are_no_news() -> None:
    clock = Clock()
    joints = JointInput(nao(), 0.5, clock)
    assert joints.take([message(10**10)]) is not None
    clock.now += 1.0
    assert joints.take([message(10**10), message(10**10 - 5)]) is None
    assert not joints.fresh
    batch = joints.take([message(10**10), message(10**10 + 5), message(10**10 + 3)])
    assert batch is not None
    assert batch.stamp_ns.tolist() == [10**10 + 5]


def test_time_may_begin_anew() -> None:
    joints = JointInput(nao(), 0.5)
    joints.take([message(10**10)])
    batch = joints.take([message(10**9)])
    assert batch is not None
    assert joints.latest is not None
    assert joints.latest.stamp_ns.tolist() == [10**9]


def test_angles_without_stamps_cannot_be_used() -> None:
    joints = JointInput(nao(), 0.5)
    assert joints.take([message(0)]) is None
    assert "no stamps" in joints.problem
