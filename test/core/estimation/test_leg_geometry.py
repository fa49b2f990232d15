"""Links of other lengths, and angles of another scale, are found by feet that stay in place."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from core.robot.test_joint_zeros import with_error
from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.estimation.leg_geometry import (
    OtherLength,
    OtherScale,
    describe_leg_errors,
    leg_errors,
)
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.workspace import config_dir

NOISE_RAD = 0.0003
AHEAD_M = (0.08, -0.06, 0.0)
"""Of the right foot, by run."""


@pytest.fixture(scope="module")
def nao_bends(nao: Robot) -> list[FloatArray]:
    """(T, m) of each run, soles in place [rad]."""
    return [bends(nao, ahead) for ahead in AHEAD_M]


@pytest.fixture(scope="module")
def nao() -> Robot:
    return load_robot(config_dir() / "robots/nao.yaml")


def shortened(robot: Robot, size: float, *joints: str) -> Robot:
    """Its files say that the links above these joints are shorter than they are [m]."""
    model = robot.model.copy()
    for name in joints:
        at = model.getJointId(name)
        placement = robot.model.jointPlacements[at]
        along = placement.translation
        short = along * (1.0 - size / np.linalg.norm(along))
        model.jointPlacements[at] = pin.SE3(placement.rotation, short)
    return replace(robot, model=model)


def bends(robot: Robot, ahead: float) -> FloatArray:
    """(T, m) knees bend and the body moves to and fro, the right foot ahead [m]."""
    kinematics, time = Kinematics(robot), np.linspace(0.0, 12.0, 90)
    angles = np.tile(robot.posture, (len(time), 1))
    bend, lean = 0.25 + 0.15 * np.sin(time), 0.08 * np.sin(1.7 * time)
    for joint, change in (("Hip", lean - bend), ("Knee", 2.0 * bend), ("Ankle", -bend - lean)):
        angles[:, robot.joint(f"L{joint}Pitch")] += change
    right = [robot.joint(f"R{joint}Pitch") for joint in ("Hip", "Knee", "Ankle")]

    def off(angles: FloatArray) -> FloatArray:
        pose = kinematics.states(angles).right_sole[:, [0, 2, 4]]
        return np.asarray(pose - [ahead, 0.0, 0.0])

    for _ in range(8):
        now, step = off(angles), 1e-6
        steps = [off(angles + step * np.eye(angles.shape[1])[one]) for one in right]
        slope = np.stack([(one - now) / step for one in steps], axis=2)
        angles[:, right] -= np.linalg.solve(slope, now[..., None])[..., 0]
    assert np.abs(off(angles)).max() < 1e-9
    return angles


def found(robot: Robot, angles: Sequence[FloatArray]) -> list[OtherLength] | list[OtherScale]:
    """By runs of a robot whose joint angles are (T, m) each [rad]."""
    kinematics = Kinematics(robot)
    rng = np.random.default_rng(1)
    aligned, standing = dict[int, Aligned](), dict[int, BoolArray]()
    for run, exact in enumerate(angles, start=1):
        read = exact + NOISE_RAD * rng.standard_normal(exact.shape)
        time = np.arange(len(read)) / 10.0
        aligned[run] = Aligned(time, np.zeros((len(read), 8)), read, kinematics.states(read))
        standing[run] = np.ones(len(read), dtype=bool)
    return leg_errors(kinematics, aligned, standing)


def test_nothing_is_said_of_right_lengths(nao: Robot, nao_bends: list[FloatArray]) -> None:
    assert found(nao, nao_bends) == []
    assert leg_errors(Kinematics(nao), {}, {}) == []
    assert describe_leg_errors([]) == []


@pytest.mark.parametrize("size", [0.012, -0.012])
@pytest.mark.parametrize("joints", [("LAnklePitch", "RAnklePitch"), ("LKneePitch", "RKneePitch")])
def test_links_of_another_length_are_named(
    nao: Robot, nao_bends: list[FloatArray], joints: tuple[str, ...], size: float
) -> None:
    lengths = found(shortened(nao, size, *joints), nao_bends)
    named = {one.joints: one.longer for one in lengths if isinstance(one, OtherLength)}
    assert named[joints] == pytest.approx(size, abs=0.002)


@pytest.mark.parametrize("joint", ["LHipPitch", "RKneePitch", "RAnklePitch"])
@pytest.mark.parametrize("size", [0.03, -0.05])
def test_zeros_stay_zeros(nao: Robot, nao_bends: list[FloatArray], joint: str, size: float) -> None:
    assert found(nao, [with_error(nao, one, joint, size) for one in nao_bends]) == []


@pytest.mark.parametrize("joint", ["LKneePitch", "RHipPitch"])
@pytest.mark.parametrize("more", [0.05, -0.08])
def test_angles_of_another_scale_are_named(
    nao: Robot, nao_bends: list[FloatArray], joint: str, more: float
) -> None:
    scale = np.ones(len(nao.joint_names))
    scale[nao.joint(joint)] = 1.0 / (1.0 + more)
    (error,) = found(nao, [scale * one for one in nao_bends])
    assert isinstance(error, OtherScale)
    assert error.joint == joint
    assert error.more == pytest.approx(more, rel=0.1)
    (finding,) = describe_leg_errors([error])
    word = "more" if more > 0.0 else "less"
    assert f"{joint} turned {abs(error.more):.1%} {word} than recorded" in finding.reason


def test_where_a_zero_explains_it_as_well_nothing_is_said(
    nao: Robot, nao_bends: list[FloatArray]
) -> None:
    assert found(shortened(nao, 0.012, "LAnklePitch"), nao_bends) == []


def test_the_words_name_links_sizes_and_joints() -> None:
    (finding,) = describe_leg_errors(
        [
            OtherLength(("l_shin", "r_shin"), ("l_ankle", "r_ankle"), -0.0123),
            OtherLength(("l_thigh",), ("l_knee",), 0.011),
        ]
    )
    assert finding.verdict == "WARN"
    assert "(l_shin and r_shin 12 mm shorter, or l_thigh 11 mm longer)" in finding.reason
    assert "the joint origins of l_ankle and r_ankle; or of l_knee in the URDF" in finding.reason
