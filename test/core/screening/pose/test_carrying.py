"""The foot that carries a walking robot stays where it is, or something is wrong."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.robot import robots
from core.shoe.shoes import made, six_axis
from shoecal_core.recording.info import RunInfo
from shoecal_core.recording.run import JointSamples, PoseSamples, Readings, Run
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.pose.carrying import describe_moving_feet, moving_feet

KINEMATICS = robots.kinematics("nao")
SHOE = made([*six_axis(0, [0.0, 0.0, 0.03]), *six_axis(1, [0.0, 0.0, 0.03])])
TIME = np.arange(0.0, 12.0, 0.01)
STEP_S = 1.0
"""On one foot, then on the other."""
WEIGHT = 50.0


@dataclass(frozen=True)
class Walk:
    """Joints, base pose and readings of a robot that turns round in place."""

    aligned: Aligned
    base: PoseSamples

    def shown(self) -> list[str]:
        """What is found."""
        shape, digest = self.aligned.readings.shape, "0" * 64
        run = Run(
            path=Path("run_001.mcap"),
            info=RunInfo(1, "walking", None, "nao", "made", digest, digest, digest),
            start_ns=0,
            joints=JointSamples(TIME, ("joint",), np.zeros((len(TIME), 1)), None),
            readings=Readings(
                TIME, SHOE.names, self.aligned.readings, np.zeros(shape, dtype=np.uint8),
                np.zeros(shape, dtype=np.int64), np.full(shape, np.nan),
            ),
            base_pose=self.base,
        )  # fmt: skip
        found = moving_feet({1: run}, {1: self.aligned}, SHOE, KINEMATICS.robot)
        return [finding.reason for finding in describe_moving_feet(found)]


@pytest.fixture(scope="module")
def walk() -> Walk:
    """Legs swing to and fro; the base moves so that the foot that carries stays."""
    names = list(KINEMATICS.robot.joint_names)
    angles = np.tile(KINEMATICS.robot.posture, (len(TIME), 1))
    swing = 0.2 * np.sin(np.pi * TIME / STEP_S)
    for side, sign in (("L", 1.0), ("R", -1.0)):
        angles[:, names.index(f"{side}HipPitch")] += sign * swing
        angles[:, names.index(f"{side}AnklePitch")] -= sign * swing
    states = KINEMATICS.states(angles)
    right_turn = states.left_rotation @ states.rotation
    right = (
        np.einsum("tij,tj->ti", states.left_rotation, states.translation) + states.left_translation
    )
    left_alone = np.cos(np.pi * TIME / STEP_S) > 0.0
    position, turns = np.zeros((len(TIME), 3)), np.zeros((len(TIME), 3, 3))
    place = np.zeros(3)
    for k in range(len(TIME)):
        turn, foot = (
            (states.left_rotation, states.left_translation)
            if left_alone[k]
            else (right_turn, right)
        )
        if k and left_alone[k] != left_alone[k - 1]:
            place = position[k - 1] + turns[k - 1] @ foot[k - 1]
        turns[k] = turn[k].T
        position[k] = place - turns[k] @ foot[k]
    load = np.stack((left_alone, ~left_alone), axis=1) * WEIGHT
    readings = np.zeros((len(TIME), len(SHOE.names)))
    for foot, name in enumerate(("left", "right")):
        # Zeros are not known.
        readings[:, SHOE.index(f"{name}/fz")] = load[:, foot] + (7.0 if foot else -9.0)
    base = PoseSamples(TIME, position, Rotation.from_matrix(turns).as_quat())
    return Walk(Aligned(TIME, readings, angles, states), base)


def test_a_walk_on_feet_that_stay(walk: Walk) -> None:
    assert walk.shown() == []


def test_a_base_pose_that_never_changes(walk: Walk) -> None:
    still = replace(
        walk.base,
        position=np.tile(walk.base.position[0], (len(TIME), 1)),
        quaternion=np.tile(walk.base.quaternion[0], (len(TIME), 1)),
    )
    (reason,) = replace(walk, base=still).shown()
    assert "base pose never changes" in reason


def test_feet_that_are_exchanged(walk: Walk) -> None:
    order = [*range(5, 10), *range(5)]
    readings = walk.aligned.readings[:, order]
    (reason,) = replace(walk, aligned=replace(walk.aligned, readings=readings)).shown()
    assert "left and right are exchanged" in reason


def test_forces_of_both_feet_with_the_other_sign(walk: Walk) -> None:
    readings = -walk.aligned.readings
    (reason,) = replace(walk, aligned=replace(walk.aligned, readings=readings)).shown()
    assert "both vertical forces are inverted" in reason


def test_a_base_pose_that_is_late(walk: Walk) -> None:
    (reason,) = replace(walk, base=replace(walk.base, time=TIME + 0.3)).shown()
    assert "the base pose 300 ms earlier" in reason


@pytest.mark.parametrize("late", [0.3, -0.3])
def test_readings_that_are_late(walk: Walk, late: float) -> None:
    """The foot stands still for most of the time that it seems to carry, but not for all of it."""
    columns = [np.interp(TIME - late, TIME, column) for column in walk.aligned.readings.T]
    (reason,) = replace(
        walk, aligned=replace(walk.aligned, readings=np.column_stack(columns))
    ).shown()
    assert f"the readings 300 ms {'earlier' if late > 0.0 else 'later'}" in reason


def test_joint_angles_that_are_late(walk: Walk) -> None:
    late = walk.aligned.joint_angles[np.clip(np.arange(len(TIME)) - 30, 0, None)]
    moved = replace(walk.aligned, joint_angles=late, states=KINEMATICS.states(late))
    (reason,) = replace(walk, aligned=moved).shown()
    assert "the joint angles 300 ms earlier" in reason


def test_a_base_pose_that_is_not_exact_is_no_fault(walk: Walk) -> None:
    """As motion capture gives it: a tenth of a millimetre, at 100 Hz."""
    shaken = walk.base.position + np.random.default_rng(1).normal(0.0, 2e-4, (len(TIME), 3))
    assert replace(walk, base=replace(walk.base, position=shaken)).shown() == []


@pytest.mark.parametrize("how", ["millimetres", "leaning"])
def test_a_base_pose_in_another_unit_or_frame(walk: Walk, how: str) -> None:
    lean = Rotation.from_euler("x", 90.0, degrees=True)
    base = (
        replace(walk.base, position=1e3 * walk.base.position)
        if how == "millimetres"
        else replace(
            walk.base,
            position=lean.apply(walk.base.position),
            quaternion=(lean * Rotation.from_quat(walk.base.quaternion)).as_quat(),
        )
    )
    (reason,) = replace(walk, base=base).shown()
    assert "check the base pose" in reason
