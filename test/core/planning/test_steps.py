"""Own steps as they are planned; in the physics they are tested with the simulation."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
import shapely

from core.planning.bodies import NAMES, load_body
from core.planning.motions import SETTINGS, SUPPORTS, planner_of, step_of
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.deflection import deflected
from shoecal_core.planning.horizon.rolling import PlanningCanceledError, Progress
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.steps import STEPS_MAX, StepError, Stepper, require_steps_left
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.planning.swing import swing_path
from shoecal_core.robot.double_support import DoubleSupport

HERE, THERE = SUPPORTS[0], SUPPORTS[1]
FEET = (SupportPhase.LEFT, SupportPhase.RIGHT)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("support_phase", FEET)
def test_one_step_leads_from_a_double_support_to_another(
    name: str, support_phase: SupportPhase
) -> None:
    motion, planner = step_of(name, support_phase), planner_of(name)
    assert motion.name == "step"
    assert [phase.name for phase in motion.phases] == ["shift", "swing", "back"]
    both = SupportPhase.BOTH
    assert [phase.support_phase for phase in motion.phases] == [both, support_phase, both]
    first, last = planner.standing(motion.positions[0]), planner.standing(motion.positions[-1])
    assert planner.legs.foot_pose(motion.positions[-1]).translation[2] == pytest.approx(0, abs=1e-4)
    np.testing.assert_allclose(first.foot_pose.translation[:2], HERE.translation, atol=1e-6)
    np.testing.assert_allclose(last.foot_pose.translation[:2], THERE.translation, atol=1e-4)
    assert last.foot_pose.support.dtheta == pytest.approx(THERE.dtheta, abs=1e-4)
    # It ends as it stands there by itself.
    wanted = planner.standing(planner.stance(THERE))
    np.testing.assert_allclose(last.cop, wanted.cop, atol=SETTINGS.landmark_radius + 1e-3)
    assert check_motion(planner.legs, motion, SETTINGS).kept
    assert Stepper(planner).step(motion.positions[-1], THERE) is None


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("support_phase", FEET)
def test_on_one_foot_every_planned_state_keeps_the_margin(
    name: str, support_phase: SupportPhase
) -> None:
    """Also where the polygon moves from state to state, as the left sole does in the air."""
    motion, robot = step_of(name, support_phase), load_body(name).robot
    shift, swing, _ = motion.path.switches
    body = track(robot, robot.from_legs(motion.path.states[shift + 1 : swing + 1]))
    places, foot = body.com, robot.feet[0]
    if support_phase is SupportPhase.RIGHT:
        away = body.com - body.right_translation
        places, foot = np.einsum("tji,tj->ti", body.right_rotation, away), robot.feet[1]
    inner = shapely.Polygon(foot.sensing_polygon).buffer(-SETTINGS.one_foot_margin + 1e-5)
    assert np.all(shapely.contains_xy(inner, *places[:, :2].T))


@pytest.mark.parametrize("support_phase", FEET)
def test_the_foot_goes_up_along_and_down(support_phase: SupportPhase) -> None:
    motion, robot = step_of("nao", support_phase), load_body("nao").robot
    swing = motion.phases[1]
    at = (motion.time >= swing.begin) & (motion.time <= swing.end)
    body = track(robot, motion.positions)
    up = body.right_translation[:, 2] * (1.0 if support_phase is SupportPhase.LEFT else -1.0)
    assert np.abs(up[~at]).max() < 1e-4
    # Joints sag under the weight on one leg: that much more it is lifted.
    torques = track(robot, motion.positions, support_phase.share).torques
    true = track(robot, deflected(robot, motion.positions, torques)).right_translation[:, 2]
    hanging = true * (1.0 if support_phase is SupportPhase.LEFT else -1.0)
    assert up.max() > SETTINGS.step_lift + 0.004
    assert hanging[at].max() > 0.8 * SETTINGS.step_lift
    # Most of its way along it is high enough.
    ground = np.linalg.norm(np.diff(body.right_translation[:, :2], axis=0), axis=1)
    high = up[1:] > 0.8 * SETTINGS.step_lift
    assert ground[high].sum() > 0.8 * ground.sum()


@pytest.mark.parametrize("name", NAMES)
def test_the_feet_take_turns(name: str) -> None:
    planner = planner_of(name)
    stepper, angles, support_phase = Stepper(planner), planner.stance(HERE), []
    for goal in (THERE, HERE, THERE):
        motion = stepper.step(angles, goal)
        assert motion is not None
        support_phase.append(motion.phases[1].support_phase)
        angles = motion.positions[-1]
    assert support_phase == [SupportPhase.LEFT, SupportPhase.RIGHT, SupportPhase.LEFT]


def test_a_foot_that_would_carry_much_longer_does_not() -> None:
    """Turning the feet takes the left foot a long way round the right one."""
    planner = planner_of("nao")
    begin, goal = DoubleSupport(-0.02, -0.136, 0.468), DoubleSupport(0.07, -0.112, -0.156)
    long, short = (
        swing_path(
            planner.legs.robot, FootPose.of(begin), FootPose.of(goal), support_phase, SETTINGS
        )
        for support_phase in (SupportPhase.RIGHT, SupportPhase.LEFT)
    )
    assert len(long) > 1.4 * len(short)
    for last in FEET:
        stepper = Stepper(planner)
        stepper.support_phase = last
        motion = stepper.step(planner.stance(begin), goal)
        assert motion is not None
        assert motion.phases[1].support_phase is SupportPhase.LEFT


def test_too_far_for_one_step_is_gone_in_several() -> None:
    """Few states a motion: then the way there has to be parted."""
    robot = load_body("nao").robot
    planner = Planner(robot, dataclasses.replace(SETTINGS, steps_max=40))
    begin, goal = DoubleSupport(-0.04, -0.13, 0.0), DoubleSupport(0.08, -0.13, 0.0)
    stepper, angles, taken = Stepper(planner), planner.stance(begin), 0
    while (motion := stepper.step(angles, goal)) is not None:
        angles, taken = motion.positions[-1], taken + 1
        assert taken < 4
    assert taken == 3
    assert stepper.arrived(planner.legs.foot_pose(angles), goal)


def test_goals_out_of_reach() -> None:
    planner = planner_of("nao")
    stepper, angles = Stepper(planner), planner.stance(HERE)
    with pytest.raises(StepError, match=r"no step leads to .*cannot stand"):
        stepper.step(angles, DoubleSupport(0.0, -0.4, 0.0))
    with pytest.raises(StepError, match=r"no step leads to .*overlap"):
        stepper.step(angles, DoubleSupport(0.0, -0.06, 0.0))


def test_a_robot_that_cannot_stand_on_one_foot_does_not_step() -> None:
    robot = load_body("nao").robot
    planner = Planner(robot, dataclasses.replace(SETTINGS, torque_share=0.45))
    with pytest.raises(StepError, match=r"no step leads to .*foot alone.*neutral") as caught:
        Stepper(planner).step(planner.stance(HERE), THERE)
    assert "\n" not in str(caught.value)


def test_progress_and_cancel() -> None:
    told: list[Progress] = []

    def stop() -> bool:
        return len(told) >= 2

    planner = planner_of("nao")
    with pytest.raises(PlanningCanceledError):
        Stepper(planner).step(planner.stance(HERE), THERE, progress=told.append, canceled=stop)
    assert [entry.landmarks for entry in told] == [3, 3]


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("seed", [1, 2])
def test_from_encoders_that_are_off(name: str, seed: int) -> None:
    """Then a standing foot seems tilted; put down again it is level and where it should be."""
    planner, robot = planner_of(name), load_body(name).robot
    stance = planner.stance(HERE)
    measured = stance + np.random.default_rng(seed).uniform(-0.01, 0.01, len(stance))
    for pair in robot.shared:
        measured[pair.joint] = pair.ratio * measured[pair.leader]
    motion = Stepper(planner).step(measured, THERE)
    assert motion is not None
    np.testing.assert_allclose(motion.positions[0], measured, atol=1e-12)
    assert np.abs(motion.foot_pose.rotation[2, :2]).max() > 1e-3
    pose = planner.legs.foot_pose(motion.positions[-1])
    np.testing.assert_allclose(pose.translation, [*THERE.translation, 0.0], atol=1e-4)
    np.testing.assert_allclose(pose.rotation[2], [0.0, 0.0, 1.0], atol=1e-4)


def test_who_needs_too_many_steps_goes_astray() -> None:
    goal = DoubleSupport(0.0, -0.11, 0.0)
    require_steps_left(STEPS_MAX - 1, goal)
    with pytest.raises(StepError, match=f"after {STEPS_MAX} steps"):
        require_steps_left(STEPS_MAX, goal)
