from __future__ import annotations

import numpy as np
import pytest
from sensor_msgs.msg import JointState

from ros.bodies import nao
from ros.clock import Clock
from shoecal_ros.common.codes import Code
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
    ms = 10**6
    knee = float(nao().posture[nao().joint("LKneePitch")]) + 0.05
    shuffled = message(20 * ms, {"LKneePitch": knee})
    order = np.random.default_rng(1).permutation(len(shuffled.name))
    shuffled.name, shuffled.position = (
        [shuffled.name[index] for index in order],
        [shuffled.position[index] for index in order],
    )
    batch = joints.take([message(10 * ms), message(15 * ms), shuffled])
    assert batch is not None
    assert batch.stamp_ns.tolist() == [10 * ms, 15 * ms, 20 * ms]
    expected = np.tile(nao().posture, (3, 1))
    expected[2, nao().joint("LKneePitch")] = knee
    np.testing.assert_array_equal(batch.angles, expected)
    assert joints.latest is not None
    assert joints.latest.stamp_ns.tolist() == [20 * ms]


def code(joints: JointInput) -> str:
    assert joints.problem is not None
    return joints.problem.code


def test_what_is_wrong_is_told_in_turn() -> None:
    clock = Clock()
    joints = JointInput(nao(), 0.5, clock)
    assert "no joint angles yet" in str(joints.problem)
    assert code(joints) == Code.NO_JOINTS
    joints.take([message(10)])
    assert joints.problem is None
    clock.now += 3.0
    assert str(joints.problem).startswith("no joint angles for 3 s")
    assert code(joints) == Code.JOINTS_STALE
    assert not joints.fresh
    assert joints.take([JointState(name=["elbow"], position=[0.0])]) is None
    assert "needs joint(s) HeadYaw" in str(joints.problem)
    assert "elbow" in str(joints.problem)
    assert code(joints) == "joints-missing"
    joints.take([message(20)])
    assert joints.problem is None


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
        raise AssertionError(str(joints.problem))


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
    assert joints.problem is None
    assert good is not None
    assert joints.latest is not None
    assert joints.latest.stamp_ns.tolist() == good.stamp_ns.tolist()
    clock.now += 0.2
    assert problem in str(joints.problem)
    joints.take([message(30)])
    assert joints.problem is None


def test_an_optional_joint_may_tell_nothing() -> None:
    joints = JointInput(nao(), 0.5)
    assert joints.take([message(10, {"LHand": float("nan")})]) is not None
    assert joints.problem is None


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
    assert joints.take([message(10**9)]) is None, "once is no evidence"
    batch = joints.take([message(10**9 + 10**7)])
    assert batch is not None
    assert joints.latest is not None
    assert joints.latest.stamp_ns.tolist() == [10**9 + 10**7]


def test_angles_without_stamps_cannot_be_used() -> None:
    joints = JointInput(nao(), 0.5)
    assert joints.take([message(0)]) is None
    assert "no stamps" in str(joints.problem)
    assert code(joints) == "unusable-joints"


STEP_NS = 10_000_000
AWAY = {"LKneePitch": 1.0, "RAnklePitch": -0.5}


def taken(joints: JointInput, messages: list[JointState]) -> list[float]:
    """Knee angles that were believed, message by message."""
    knee = nao().joint("LKneePitch")
    batches = [joints.take([one]) for one in messages]
    return [float(batch.angles[-1, knee]) for batch in batches if batch is not None]


@pytest.mark.parametrize("behind_ns", [0, 300_000_000, 86_400 * 10**9])
def test_two_senders_of_the_same_joints_are_told_by_name_and_neither_is_used(
    behind_ns: int,
) -> None:
    clock = Clock()
    joints = JointInput(nao(), 0.5, clock, senders=lambda: ["/bag", "/robot"])
    begin = 10**14
    for index in range(100):
        clock.now += 0.01
        own = begin + index * STEP_NS
        heard = taken(joints, [message(own), message(own + STEP_NS // 2 - behind_ns, AWAY)])
        assert 1.0 not in heard, "the other sender's angles are never taken"
        assert not heard or index < 10
    assert not joints.fresh
    assert joints.silent
    reported = "joint angles run to and fro between '/bag' and '/robot'; stop all but one"
    assert str(joints.problem).startswith(reported)
    assert code(joints) == Code.JOINTS_CONTRADICT
    own = begin + 100 * STEP_NS
    heard = taken(joints, [message(own + index * STEP_NS) for index in range(60)])
    assert heard, "the one that stays is used again"
    assert joints.problem is None


def to_and_fro(joints: JointInput, samples: range) -> None:
    taken(joints, [message(i * STEP_NS, AWAY if i % 2 else None) for i in samples])


def test_who_contradicts_is_named_as_soon_as_its_name_is_known_and_as_long_as_that_lasts() -> None:
    senders = ["/robot", "somebody without a node's name"]
    clock = Clock()
    joints = JointInput(nao(), 60.0, clock, senders=lambda: senders)
    to_and_fro(joints, range(100, 120))
    assert "'somebody without a node's name'" in str(joints.problem)
    senders[1] = "/bag"
    clock.now += 1.0
    to_and_fro(joints, range(120, 122))
    between = "between '/robot' and '/bag'; stop all but one"
    assert between in str(joints.problem)
    senders.remove("/bag")
    clock.now += 1.0
    taken(joints, [message(i * STEP_NS) for i in range(122, 130)])
    assert between in str(joints.problem), "the robot left alone is not to blame"
    senders.clear()
    assert between in str(joints.problem), "nor does it lose the name where nothing more comes"
    senders += ["/robot"]
    taken(joints, [message(i * STEP_NS) for i in range(130, 180)])
    assert joints.problem is None
    to_and_fro(joints, range(180, 200))
    assert "all from '/robot'; let one node alone" in str(joints.problem), "that was another time"
    senders.clear()
    clock.now += 1.0
    to_and_fro(joints, range(200, 202))
    assert "all from '/robot'" in str(joints.problem)


def test_of_three_who_send_two_that_are_left_are_not_to_blame() -> None:
    senders = ["/bag", "/hand", "/robot"]
    clock = Clock()
    joints = JointInput(nao(), 0.5, clock, senders=lambda: senders)
    to_and_fro(joints, range(100, 120))
    senders.remove("/bag")
    clock.now += 1.0
    taken(joints, [message(i * STEP_NS) for i in range(120, 130)])
    assert "between '/bag' and '/hand' and '/robot'" in str(joints.problem)


def test_who_sends_is_not_asked_for_with_every_message() -> None:
    asked = []
    clock = Clock()

    def senders() -> list[str]:
        asked.append(clock.now)
        return ["/bag", "/robot"]

    joints = JointInput(nao(), 0.5, clock, senders=senders)
    for sample in range(100, 400, 2):
        clock.now += 0.02
        to_and_fro(joints, range(sample, sample + 2))
    assert len(asked) > 10
    assert np.diff(asked).min() > 0.099


def test_a_sample_that_leaps_and_comes_back_is_left_out() -> None:
    joints = JointInput(nao(), 0.5)
    for index in range(100):
        changes = AWAY if index % 40 == 20 else None
        heard = taken(joints, [message((100 + index) * STEP_NS, changes)])
        assert bool(heard) == (changes is None)
        assert joints.problem is None


def test_a_robot_that_was_put_elsewhere_is_believed_at_the_second_sample() -> None:
    joints = JointInput(nao(), 0.5)
    messages = [message((100 + i) * STEP_NS, AWAY if i >= 10 else None) for i in range(20)]
    heard = taken(joints, messages)
    assert len(heard) == 19
    assert heard[10:] == [1.0] * 9


@pytest.mark.parametrize("batch", [1, 7])
def test_motion_as_fast_as_joints_can_is_followed(batch: int) -> None:
    joints = JointInput(nao(), 0.5)
    speed = float(nao().velocity_limit[nao().joint("LKneePitch")])
    rng = np.random.default_rng(1)
    count = 0
    for first in range(0, 210, batch):
        messages = [
            message(
                (100 + index) * STEP_NS + round(2e6 * rng.standard_normal()),
                {"LKneePitch": 0.5 * np.sin(speed / 0.5 * index * STEP_NS / 1e9)},
            )
            for index in range(first, first + batch)
        ]
        found = joints.take(messages)
        assert found is not None
        count += len(found.stamp_ns)
    assert count == 210
    assert joints.problem is None
