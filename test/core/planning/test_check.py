"""Every way to spoil a motion is found and named."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from core.planning.bodies import load_body
from core.planning.motions import SETTINGS, motion_of
from shoecal_core.planning.body_track import load_share, track
from shoecal_core.planning.check import check_motion
from shoecal_core.planning.findings import CheckFailedError, Report
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.settings import PlannerSettings

BODY = load_body("nao")


def checked(motion: Motion, settings: PlannerSettings = SETTINGS) -> Report:
    return check_motion(BODY.legs, motion, settings)


def with_joint(motion: Motion, name: str, change: np.ndarray | float) -> Motion:
    positions = motion.positions.copy()
    positions[:, BODY.robot.joint(name)] += change
    return dataclasses.replace(motion, positions=positions)


def bump(motion: Motion, size: float) -> np.ndarray:
    """A slow swelling in the middle of the motion."""
    phase = np.clip((motion.time - 5.0) / (motion.duration - 10.0), 0.0, 1.0)
    return np.asarray(size * np.sin(np.pi * phase) ** 2)


SPOILT: dict[str, Callable[[Motion], Motion]] = {
    "distance from joint limits": lambda motion: with_joint(motion, "RAnkleRoll", 0.35),
    "drift of the way between the feet": lambda motion: with_joint(
        motion, "RKneePitch", bump(motion, 0.01)
    ),
    "drift of the turn between the feet": lambda motion: with_joint(
        motion, "RAnkleRoll", bump(motion, 0.01)
    ),
    "joint speed": lambda motion: with_joint(
        motion, "HeadYaw", np.where(motion.time > 9.0, 0.01, 0.0)
    ),
    "CoM speed": lambda motion: dataclasses.replace(motion, time=motion.time / 2.0),
    "shift of the CoP by acceleration": lambda motion: dataclasses.replace(
        motion, time=motion.time / 2.0
    ),
    "distance of the CoP from the edge of the sensing polygon": lambda motion: with_joint(
        with_joint(motion, "LAnklePitch", bump(motion, 0.3)), "RAnklePitch", bump(motion, 0.3)
    ),
    "distance between capsules": lambda motion: with_joint(
        with_joint(motion, "LHipRoll", -bump(motion, 0.25)), "RHipRoll", bump(motion, 0.25)
    ),
    "way while holding still": lambda motion: with_joint(motion, "HeadPitch", 1e-3 * motion.time),
}


@pytest.mark.parametrize("constraint", SPOILT)
def test_a_violation_is_named(constraint: str) -> None:
    report = checked(SPOILT[constraint](motion_of("nao")))
    assert not report.of(constraint).kept
    with pytest.raises(CheckFailedError, match=constraint) as caught:
        report.require()
    assert constraint in [finding.constraint for finding in caught.value.findings]


def test_weak_motors() -> None:
    weak = dataclasses.replace(SETTINGS, torque_share=0.3)
    # At the begin the motors already need more; a motion must not need more than that.
    finding = checked(motion_of("nao"), weak).of("static torque")
    assert not finding.kept
    assert "Knee" in finding.where


def test_a_good_motion_passes() -> None:
    report = checked(motion_of("nao"))
    report.require()
    assert report.kept
    assert len(report.findings) == 10


def test_time_and_place_of_the_worst() -> None:
    motion = motion_of("nao")
    spoilt = with_joint(motion, "RKneePitch", np.where(motion.time == 12.0, 0.05, 0.0))
    finding = checked(spoilt).of("drift of the way between the feet")
    assert finding.time == 12.0
    # The knee is a shin, a foot and a shoe (0.17 m) above the sole.
    assert finding.value == pytest.approx(0.05 * 0.17, rel=0.05)
    assert "at 12.00 s" in str(finding)


def test_a_begin_outside_a_margin_must_not_get_worse() -> None:
    motion = motion_of("nao")
    far = dataclasses.replace(SETTINGS, joint_margin=0.4)
    first = dataclasses.replace(
        motion, positions=np.tile(motion.positions[0], (len(motion.time), 1))
    )
    assert checked(first, far).of("distance from joint limits").kept
    assert not checked(motion, far).of("distance from joint limits").kept


def test_shares_give_the_cop() -> None:
    pose = motion_of("nao").foot_pose
    cop = np.array([(0.02, -0.06), (0.0, 0.01), (0.03, -0.13), (0.0, -0.3)])
    share, places = load_share(
        BODY.robot, np.tile(pose.rotation, (4, 1, 1)), np.tile(pose.translation, (4, 1)), cop
    )
    assert np.all((share >= 0.0) & (share <= 1.0))
    assert share[1] > 0.9
    assert share[3] == 0.0
    both = share[:, None] * places[:, 0] + (1.0 - share[:, None]) * places[:, 1]
    np.testing.assert_allclose(both, cop, atol=1e-12)


def test_torques_do_the_work_of_lifting() -> None:
    """Both feet stay, so the floor does no work: what the motors do lifts the CoM."""
    robot, states = BODY.robot, motion_of("nao").path.states
    seen = track(robot, robot.from_legs(states))
    work = np.sum((seen.torques[1:] + seen.torques[:-1]) / 2.0 * np.diff(states, axis=0), axis=1)
    lifted = robot.weight * np.diff(seen.com[:, 2])
    assert np.abs(lifted).max() > 0.02
    np.testing.assert_allclose(work, lifted, atol=1e-3)


def test_too_fast_is_told_from_what_slowness_does_not_mend() -> None:
    motion = motion_of("nao")
    assert not checked(motion).too_fast
    hasty = SPOILT["CoM speed"](motion)
    assert checked(hasty).too_fast
    assert not checked(SPOILT["distance from joint limits"](hasty)).too_fast
