"""Every way to spoil a motion is found and named."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest

from core.planning.bodies import NAMES, load_body
from core.planning.motions import SETTINGS, motion_of, planner_of, step_of
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.checking.findings import CheckFailedError, Report
from shoecal_core.planning.horizon.problem import Scene
from shoecal_core.planning.legs import FootPose, Legs
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.standing import feet_gap

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
    assert finding.where.endswith(("KneePitch", "AnklePitch"))


def test_a_good_motion_passes() -> None:
    report = checked(motion_of("nao"))
    report.require()
    assert report.kept
    assert len(report.findings) == 14


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


def test_a_foot_without_enough_load_is_named() -> None:
    heavy = dataclasses.replace(SETTINGS, load_share=0.45)
    finding = checked(motion_of("nao"), heavy).of("load of a foot that stands")
    assert not finding.kept
    assert finding.where in ("left", "right")
    assert finding.limit <= 0.45 * BODY.robot.weight


def test_a_slippery_floor_is_named() -> None:
    slippery = Legs(dataclasses.replace(BODY.robot, friction=0.3))
    finding = check_motion(slippery, motion_of("nao"), SETTINGS).of(
        "sideways force over load of a foot"
    )
    assert not finding.kept
    assert finding.value > finding.limit


def test_a_torso_that_leans_too_far_is_named() -> None:
    upright = Legs(dataclasses.replace(BODY.robot, tilt_max=0.1))
    report = check_motion(upright, motion_of("nao"), SETTINGS)
    assert not report.of("tilt of the torso").kept
    assert report.of("tilt of the torso").value > 0.1
    assert checked(motion_of("nao")).of("tilt of the torso").value < BODY.robot.tilt_max


def test_joints_with_more_play_need_wider_margins() -> None:
    play = dataclasses.replace(BODY.robot.deflection, play=4.0 * BODY.robot.deflection.play)
    loose = Legs(dataclasses.replace(BODY.robot, deflection=play))
    report = check_motion(loose, motion_of("nao"), SETTINGS)
    for constraint in ("load of a foot that stands", "static torque"):
        assert not report.of(constraint).kept


def while_carried(motion: Motion, size: float) -> np.ndarray:
    """A swelling of a joint in the middle of the one phase in which a foot is carried."""
    swing = motion.phases[1]
    part = np.clip((motion.time - swing.begin) / (swing.end - swing.begin), 0.0, 1.0)
    return np.asarray(size * np.sin(np.pi * part) ** 2)


def said_elsewhere(motion: Motion) -> Motion:
    """The foot is put down 2 mm from where the motion says that it will stand."""
    shift, swing, back = motion.phases
    support = back.foot_poses[0].support
    pose = FootPose.of(dataclasses.replace(support, dx=support.dx + 0.002))
    swing = dataclasses.replace(swing, foot_poses=(swing.foot_poses[0], pose))
    back = dataclasses.replace(back, foot_poses=(pose, pose))
    return dataclasses.replace(motion, phases=(shift, swing, back))


SPOILT_STEPS: dict[str, Callable[[Motion], Motion]] = {
    "height of the foot in the air": lambda motion: with_joint(
        motion, "RKneePitch", while_carried(motion, -0.35)
    ),
    "drift of the way between the feet": said_elsewhere,
    "distance of the CoP from the edge of the sensing polygon": lambda motion: with_joint(
        motion, "LAnkleRoll", while_carried(motion, 0.2)
    ),
    "gap between the outlines of the feet": lambda motion: with_joint(
        motion, "RHipRoll", while_carried(motion, 0.25)
    ),
}


@pytest.mark.parametrize("constraint", SPOILT_STEPS)
def test_a_violation_by_a_step_is_named(constraint: str) -> None:
    motion = step_of("nao", SupportPhase.LEFT)
    checked(motion).require()
    finding = checked(SPOILT_STEPS[constraint](motion)).of(constraint)
    assert not finding.kept
    assert motion.phases[1].begin <= finding.time


def test_weak_motors_on_one_foot() -> None:
    motion = step_of("nao", SupportPhase.LEFT)
    swing = motion.phases[1]
    finding = checked(motion, dataclasses.replace(SETTINGS, torque_share=0.5)).of("static torque")
    assert not finding.kept
    assert swing.begin <= finding.time <= swing.end
    assert finding.where.startswith("L")


def test_a_foot_that_was_there_all_along_may_be_put_down_again() -> None:
    """Feet nearer than the clearance: going back there is no violation, going nearer is."""
    motion = step_of("nao", SupportPhase.LEFT)
    wide = dataclasses.replace(SETTINGS, foot_clearance=0.05)
    finding = checked(motion, wide).of("gap between the outlines of the feet")
    first, last = motion.phases[0].foot_poses[0], motion.phases[-1].foot_poses[1]
    begin, end = (feet_gap(BODY.robot, pose.support) for pose in (first, last))
    assert finding.limit == pytest.approx(min(0.8 * 0.05, begin) - SETTINGS.foot_drift, abs=1e-6)
    assert finding.kept is (end >= finding.limit)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("support_phase", [SupportPhase.LEFT, SupportPhase.RIGHT])
def test_torques_on_one_foot_do_the_work_of_lifting(name: str, support_phase: SupportPhase) -> None:
    """That foot stays, so each motor's torque is what turning it alone changes of the height."""
    body, motion = load_body(name), step_of(name, support_phase)
    robot, side = body.robot, 0 if support_phase is SupportPhase.LEFT else 1
    shift, swing, _ = motion.path.switches
    legs = motion.path.states[(shift + swing) // 2]
    torques = track(robot, robot.from_legs(legs)[None], support_phase.share).torques[0]
    step = 1e-5
    turned = legs + step * np.vstack([np.eye(len(legs)), -np.eye(len(legs))])
    height = body.legs.kinematics.states(robot.from_legs(turned)).com[:, side, 2]
    up, down = np.split(robot.weight * height, 2)
    np.testing.assert_allclose(torques, (up - down) / (2.0 * step), atol=2e-4)
    # What hangs in the air weighs less than what stands.
    names = np.array(robot.leg_names)
    hanging = np.char.startswith(np.char.lower(names), "r" if side == 0 else "l")
    assert np.abs(torques[hanging]).max() < np.abs(torques[~hanging]).max()


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("support_phase", [SupportPhase.LEFT, SupportPhase.RIGHT])
def test_planner_and_check_agree_on_one_foot(name: str, support_phase: SupportPhase) -> None:
    """Expressions of the planner against Pinocchio and numpy, in states that were planned."""
    motion, planner = step_of(name, support_phase), planner_of(name)
    robot = load_body(name).robot
    shift, swing, _ = motion.path.switches
    states = motion.path.states[shift + 1 : swing + 1]
    seen = track(robot, robot.from_legs(states), support_phase.share)
    for index, state in enumerate(states[::6]):
        pose = FootPose(seen.right_rotation[6 * index], seen.right_translation[6 * index])
        scene = Scene.of(
            support_phase.polygon(robot, pose), 0.0, pose, robot.posture, support_phase.share
        )
        told = planner.horizon.collocation.evaluate(state[None], scene)
        # The planner takes soles as level, which a foot just lifted is but nearly.
        np.testing.assert_allclose(told.torques[0], seen.torques[6 * index], atol=1e-3)
        np.testing.assert_allclose(told.cop[0], seen.com[6 * index, :2], atol=1e-9)


def test_a_foot_that_is_dragged_is_found() -> None:
    motion = step_of("nao", SupportPhase.LEFT)
    name = "height of the foot that is carried along"
    assert checked(motion).of(name).value > SETTINGS.step_lift / 3.0
    high = dataclasses.replace(SETTINGS, step_lift=6.0 * SETTINGS.step_lift)
    assert not checked(motion, high).of(name).kept
