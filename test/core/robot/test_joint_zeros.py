"""A joint whose zero is off is found by soles that stand on one floor."""

from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_laws import Law
from shoecal_core.robot.joint_zeros import OpenLoop, open_loop
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.workspace import config_dir

NAMES = ("LHipRoll", "LHipPitch", "LKneePitch", "LAnklePitch", "LAnkleRoll")


@pytest.fixture(scope="module")
def nao() -> Kinematics:
    return Kinematics(load_robot(config_dir() / "robots/nao.yaml"))


def sway(robot: Robot) -> FloatArray:
    """(T, m) both legs bend alike, then lean to the side: soles stay level and where they are."""
    time = np.linspace(0.0, 6.0, 90)
    bend, lean = 0.15 * np.sin(time), 0.08 * np.sin(2.0 * time)
    angles = np.tile(robot.posture, (len(time), 1))
    for side in "LR":
        for joint, change in (
            ("HipPitch", -bend), ("KneePitch", 2.0 * bend), ("AnklePitch", -bend),
            ("HipRoll", lean), ("AnkleRoll", -lean),
        ):  # fmt: skip
            angles[:, robot.joint(f"{side}{joint}")] += change
    return angles


def with_error(robot: Robot, angles: FloatArray, joint: str, size: float) -> FloatArray:
    wrong = angles.copy()
    wrong[:, robot.joint(joint)] += size
    return wrong


def found(kinematics: Kinematics, angles: FloatArray) -> OpenLoop:
    loop = open_loop(kinematics, angles)
    assert loop is not None
    return loop


def test_nothing_is_said_of_good_zeros(nao: Kinematics) -> None:
    angles = sway(nao.robot)
    assert open_loop(nao, angles) is None
    small = with_error(nao.robot, angles, "LKneePitch", 0.04)
    assert open_loop(nao, small) is None
    assert open_loop(nao, angles[:0]) is None


@pytest.mark.parametrize("joint", NAMES)
@pytest.mark.parametrize("size", [-0.2, 0.1, 0.35, 1.0])
def test_the_joint_and_its_error(nao: Kinematics, joint: str, size: float) -> None:
    loop = found(nao, with_error(nao.robot, sway(nao.robot), joint, size))
    assert dict(loop.fits)[joint] == pytest.approx(-size, abs=0.02)
    tilt = np.degrees(abs(size))
    assert np.degrees(loop.tilt) == pytest.approx(tilt, abs=2.0)
    assert f"(best fit: {loop.fits[0][0]} by {loop.fits[0][1]:+.2f} rad" in loop.text(loaded=True)
    assert f"tilted by {np.degrees(loop.tilt):.0f} degrees against each other while both" in (
        loop.text(loaded=True)
    )
    assert "if both feet stand, a joint's zero is off" in loop.text(loaded=False)


def test_legs_that_bend_alike_leave_two_joints_to_choose_from(nao: Kinematics) -> None:
    """A left knee that reads too much and a right one that reads too little look the same."""
    still = np.tile(nao.robot.posture, (5, 1))
    loop = found(nao, with_error(nao.robot, still, "LKneePitch", 0.6))
    fits = dict(loop.fits)
    assert fits["LKneePitch"] == pytest.approx(-0.6, abs=0.03)
    assert fits["RKneePitch"] == pytest.approx(0.6, abs=0.03)
    assert " or RKneePitch as recorded" in loop.text(loaded=True) or "RKneePitch or LKneePitch" in (
        loop.text(loaded=True)
    )


def test_a_joint_on_a_shared_motor_that_is_measured_itself(nao: Kinematics) -> None:
    loop = found(nao, with_error(nao.robot, sway(nao.robot), "RHipYawPitch", 0.7))
    assert dict(loop.fits)["RHipYawPitch"] == pytest.approx(-0.7, abs=0.02)


def test_two_joints_are_not_blamed_on_one(nao: Kinematics) -> None:
    wrong = with_error(nao.robot, sway(nao.robot), "LKneePitch", 0.4)
    loop = found(nao, with_error(nao.robot, wrong, "RHipRoll", 0.3))
    assert loop.fits == ()
    assert "no single joint's zero explains it" in loop.text(loaded=True)


def test_a_foot_that_steps_is_no_error_of_a_zero(nao: Kinematics) -> None:
    """The right foot is lifted and put down elsewhere, again and again."""
    angles = sway(nao.robot)
    time = np.linspace(0.0, 6.0, len(angles))
    step = np.clip(np.sin(4.0 * time), 0.0, None)
    for joint, share in (("RHipPitch", -0.5), ("RKneePitch", 1.0), ("RAnklePitch", -0.4)):
        angles[:, nao.robot.joint(joint)] += share * step
    assert open_loop(nao, angles) is None


def test_samples_with_a_foot_in_the_air_do_not_hide_the_joint(nao: Kinematics) -> None:
    angles = with_error(nao.robot, sway(nao.robot), "LHipRoll", 0.3)
    angles[60:, nao.robot.joint("RKneePitch")] += 0.5
    assert dict(found(nao, angles).fits)["LHipRoll"] == pytest.approx(-0.3, abs=0.02)


@pytest.mark.parametrize("joint", NAMES)
def test_a_joint_whose_sign_is_turned(nao: Kinematics, joint: str) -> None:
    angles = sway(nao.robot)
    angles[:, nao.robot.joint(joint)] *= -1.0
    loop = found(nao, angles)
    assert (loop.law, loop.names) == (Law.SIGN, (joint,))
    assert f"a joint's sign is turned (best fit: {joint} with the other sign)" in (
        loop.text(loaded=True)
    )


@pytest.mark.parametrize("joint", ["HipRoll", "AnkleRoll"])
def test_the_same_joint_of_both_legs_with_the_other_sign(nao: Kinematics, joint: str) -> None:
    angles = sway(nao.robot)
    angles[:, [nao.robot.joint(f"{side}{joint}") for side in "LR"]] *= -1.0
    wide = apart(nao.robot, angles, joint)
    loop = open_loop(nao, wide, angles)
    assert loop is not None
    assert loop.law is Law.SIGNS
    # Legs that lean as one turn hips and ankles against each other: either pair explains it.
    assert set(loop.names) == {"LHipRoll and RHipRoll", "LAnkleRoll and RAnkleRoll"}
    assert "with the other sign); correct both signs" in loop.text(loaded=True)


def apart(robot: Robot, angles: FloatArray, turned: str) -> FloatArray:
    """The same with the feet wider apart, by rolls of which one's sign is turned."""
    wide = angles.copy()
    for side, way in (("L", 1.0), ("R", -1.0)):
        for joint, sign in (("HipRoll", 1.0), ("AnkleRoll", -1.0)):
            written = -sign if joint == turned else sign
            wide[:, robot.joint(f"{side}{joint}")] += way * written * 0.15
    return wide


@pytest.mark.parametrize("joint", ["LKneePitch", "RAnkleRoll", "RHipPitch"])
@pytest.mark.parametrize("factor", [0.5, 2.0, 1.5, np.pi / 180.0, 180.0 / np.pi])
def test_a_joint_whose_angle_has_another_scale(nao: Kinematics, joint: str, factor: float) -> None:
    angles = sway(nao.robot)
    more = 0.2 * np.sin(np.linspace(0.0, 18.0, len(angles)))
    for side in "LR":
        for name, share in (
            ("HipPitch", -1.0), ("KneePitch", 2.0), ("AnklePitch", -1.0),
            ("HipRoll", 1.0), ("AnkleRoll", -1.0),
        ):  # fmt: skip
            angles[:, nao.robot.joint(f"{side}{name}")] += share * more
    angles[:, nao.robot.joint(joint)] *= factor
    loop = found(nao, angles)
    assert loop.law is Law.SCALE
    sizes = dict(zip(loop.names, loop.factors, strict=True))
    assert sizes[joint] == pytest.approx(1.0 / factor, rel=0.02)
    assert f"{joint} times {sizes[joint]:.3g}" in loop.text(loaded=True)


@pytest.mark.parametrize(
    ("one", "other"),
    [("LKneePitch", "LAnklePitch"), ("LHipPitch", "LHipRoll"), ("LKneePitch", "RAnklePitch")],
)
def test_two_joints_at_each_others_place(nao: Kinematics, one: str, other: str) -> None:
    angles = sway(nao.robot)
    places = [nao.robot.joint(one), nao.robot.joint(other)]
    angles[:, places] = angles[:, places[::-1]]
    loop = found(nao, angles)
    assert loop.law is Law.EXCHANGED
    assert {one, other} == set(loop.names[0].split(" and "))
    assert "two joints are exchanged (best fit: " in loop.text(loaded=True)


@pytest.mark.parametrize("joint", NAMES)
def test_an_encoder_that_stays_where_it_is(nao: Kinematics, joint: str) -> None:
    """It looks like a foot that is lifted now and then."""
    angles = sway(nao.robot)
    index = nao.robot.joint(joint)
    angles[:, index] = np.median(angles[:, index])
    loop = found(nao, angles)
    assert (loop.law, loop.names) == (Law.FROZEN, (joint,))
    assert f"{joint} moves, and its recorded angle does not" in loop.text(loaded=True)


def test_of_feet_that_may_swing_no_encoder_is_blamed(nao: Kinematics) -> None:
    """A leg that swings about one joint brings its sole where another joint would keep it."""
    angles = sway(nao.robot)
    index = nao.robot.joint("LAnklePitch")
    angles[:, index] = np.median(angles[:, index])
    loop = found(nao, angles)
    assert loop.named(loaded=True)
    assert not loop.named(loaded=False)


def test_runs_are_pooled_by_what_explains_them(nao: Kinematics) -> None:
    angles = sway(nao.robot)
    turned, again, frozen = angles.copy(), angles[::2].copy(), angles.copy()
    for changed in (turned, again):
        changed[:, nao.robot.joint("LKneePitch")] *= -1.0
    frozen[:, nao.robot.joint("LKneePitch")] = nao.robot.posture[nao.robot.joint("LKneePitch")]
    one = found(nao, turned)
    both = one.with_another(found(nao, again))
    assert both is not None
    assert (both.law, both.names) == (one.law, one.names)
    assert one.with_another(found(nao, frozen)) is None


def test_one_cause_of_runs_that_look_alike_alone(nao: Kinematics) -> None:
    """A zero that explains each of two runs, and another size in each, explains neither."""
    one = with_error(nao.robot, sway(nao.robot), "LAnkleRoll", 0.3)
    other = with_error(nao.robot, sway(nao.robot), "LAnkleRoll", -0.3)
    assert found(nao, one).fits
    assert found(nao, other).fits
    both = open_loop(nao, one, other)
    assert both is not None
    assert not both.named(loaded=True)


def test_feet_may_stand_elsewhere_in_every_run(nao: Kinematics) -> None:
    angles = sway(nao.robot)
    runs = (angles, apart(nao.robot, angles, ""))
    assert open_loop(nao, *runs) is None
    assert open_loop(nao) is None
    loop = open_loop(nao, *(with_error(nao.robot, one, "LHipRoll", 0.3) for one in runs))
    assert loop is not None
    assert dict(loop.fits)["LHipRoll"] == pytest.approx(-0.3, abs=0.02)
    alone = found(nao, with_error(nao.robot, angles, "LHipRoll", 0.35)).by(loop)
    assert alone.fits == loop.fits


def test_a_sign_is_not_blamed_for_a_zero(nao: Kinematics) -> None:
    """Of a robot that stands still as well."""
    still = np.tile(nao.robot.posture, (5, 1))
    loop = found(nao, with_error(nao.robot, still, "LHipPitch", 0.4))
    assert loop.law is None
    assert "LHipPitch" in dict(loop.fits)


def test_a_turn_of_a_hip_that_makes_the_soles_wander() -> None:
    """They stay level: a yaw joint of a robot whose hips lean."""
    kinematics = Kinematics(load_robot(config_dir() / "robots/wren.yaml"))
    robot, time = kinematics.robot, np.linspace(0.0, 6.0, 90)
    angles = np.tile(robot.posture, (len(time), 1))
    for name, sign in (("hip_sway", 1.0), ("ankle_sway", -1.0)):
        for side in ("left", "right"):
            turned = sign if side == "left" else -sign
            angles[:, robot.joint(f"{side}_{name}")] += turned * 0.25 * np.sin(time)
    assert open_loop(kinematics, angles) is None
    loop = found(kinematics, with_error(robot, angles, "left_hip_turn", 0.25))
    assert dict(loop.fits)["left_hip_turn"] == pytest.approx(-0.25, abs=0.02)
