"""Whole motions, looked at independently of what planned them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pinocchio as pin
import pytest
import shapely

from core.planning.bodies import NAMES, load_body
from core.planning.motions import SETTINGS, SUPPORTS, motion_of, planner_of
from shoecal_core.errors import NameNotFoundError, ShapeError
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.horizon.rolling import Path, PlanningCanceledError, Progress
from shoecal_core.planning.landmarks import Contour, sensing_hull
from shoecal_core.planning.legs import Legs
from shoecal_core.planning.motion import Motion, timed
from shoecal_core.planning.motion_catalogue import FASTER
from shoecal_core.planning.planner import Planner, StartError
from shoecal_core.planning.posture import middle
from shoecal_core.planning.segment import MotionSegment, cop_segment
from shoecal_core.planning.settings import PlannerSettings

CASES = [(name, index) for name in NAMES for index in range(len(SUPPORTS))]


@pytest.mark.parametrize(("name", "index"), CASES)
def test_constraints_hold_in_every_planned_state(name: str, index: int) -> None:
    body, support = load_body(name), SUPPORTS[index]
    robot, states = body.robot, motion_of(name, index).path.states
    seen = track(robot, robot.from_legs(states))
    tolerance = SETTINGS.tolerance
    lower, upper = (limit[robot.legs] for limit in (robot.lower, robot.upper))
    assert np.all(states >= lower + SETTINGS.joint_margin - tolerance)
    assert np.all(states <= upper - SETTINGS.joint_margin + tolerance)
    inner = sensing_hull(robot, support).buffer(-SETTINGS.stability_margin + tolerance)
    assert np.all(shapely.contains_xy(inner, *seen.com[:, :2].T))
    assert seen.distances.min() >= SETTINGS.capsule_clearance - tolerance
    way = seen.right_translation - [support.dx, support.dy, 0.0]
    assert np.abs(way).max() < tolerance
    turn = pin.rpy.rpyToMatrix(0.0, 0.0, support.dtheta).T @ seen.right_rotation
    assert np.abs(turn - np.eye(3)).max() < tolerance
    motors = robot.effort_limit[robot.legs] * SETTINGS.torque_share
    assert np.all(np.abs(seen.torques) <= motors * 1.001)
    moves = np.abs(np.diff(states, axis=0))
    assert moves.max() <= SETTINGS.joint_speed * SETTINGS.step_time + tolerance


@pytest.mark.parametrize(("name", "index"), CASES)
def test_the_trajectory_keeps_every_constraint(name: str, index: int) -> None:
    report = check_motion(load_body(name).legs, motion_of(name, index), SETTINGS)
    assert report.kept, report
    assert report.of("drift of the way between the feet").value < 1e-4


@pytest.mark.parametrize(("name", "index"), CASES)
def test_the_cop_goes_round(name: str, index: int) -> None:
    motion, robot = motion_of(name, index), load_body(name).robot
    contour = Contour.of(robot, SUPPORTS[index])
    # In a symmetric support two sides are equally near, and rounding chooses.
    first = motion.path.targets[0]
    away = np.linalg.norm(contour.midpoints - motion.cop[0], axis=1)
    assert np.linalg.norm(first - motion.cop[0]) <= away.min() + 1e-6
    # What is too far out is moved in, towards the middle between the feet.
    wanted, centre = contour.targets(first)[1:], middle(robot, SUPPORTS[index])
    moved = motion.path.targets[1:] - wanted
    inward = np.sum(moved * (centre - wanted), axis=1) / np.sum((centre - wanted) ** 2, axis=1)
    np.testing.assert_allclose(moved, inward[:, None] * (centre - wanted), atol=1e-9)
    assert np.all((inward > -1e-9) & (inward < 0.5))
    assert np.sum(motion.path.nearest < SETTINGS.landmark_radius) >= 4
    ring = shapely.Polygon(motion.cop)
    assert ring.area > 0.3 * shapely.Polygon(contour.corners).area
    assert 20.0 < motion.duration < 50.0


@pytest.mark.parametrize("name", NAMES)
def test_from_rest_to_rest(name: str) -> None:
    motion, robot = motion_of(name), load_body(name).robot
    assert motion.joint_names == robot.joint_names
    assert motion.positions.shape == (len(motion.time), len(robot.joint_names))
    holds = motion.time <= SETTINGS.hold_time
    np.testing.assert_array_equal(motion.velocities[holds], 0.0)
    np.testing.assert_allclose(motion.velocities[-1], 0.0, atol=1e-6)
    ends = motion.time >= motion.duration - SETTINGS.hold_time
    np.testing.assert_allclose(
        motion.positions[ends], np.tile(motion.positions[-1], (ends.sum(), 1)), atol=1e-7
    )
    slopes = np.gradient(motion.positions, motion.time, axis=0)
    np.testing.assert_allclose(motion.velocities, slopes, atol=5e-3)
    arms = np.setdiff1d(
        np.arange(len(robot.joint_names)), [*robot.legs, *(pair.joint for pair in robot.shared)]
    )
    np.testing.assert_array_equal(
        motion.positions[:, arms], np.tile(robot.posture[arms], (len(motion.time), 1))
    )


def test_a_shared_motor_moves_both_joints() -> None:
    motion, robot = motion_of("nao"), load_body("nao").robot
    left, right = (robot.joint(name) for name in ("LHipYawPitch", "RHipYawPitch"))
    np.testing.assert_array_equal(motion.positions[:, left], motion.positions[:, right])
    assert np.ptp(motion.positions[:, left]) > 0.01


def test_the_same_again() -> None:
    again = Planner(load_body("odd_biped").robot, SETTINGS).plan(SUPPORTS[0])
    np.testing.assert_array_equal(again.positions, motion_of("odd_biped").positions)


def test_the_menu() -> None:
    planner, first = planner_of("odd_biped"), motion_of("odd_biped")
    backwards = planner.plan(SUPPORTS[0], "reversed")
    assert backwards.name == "reversed"
    np.testing.assert_allclose(backwards.path.targets[1:], first.path.targets[:0:-1])
    faster = planner.plan(SUPPORTS[0], "faster")
    np.testing.assert_array_equal(faster.path.states, first.path.states)
    holds = 2.0 * SETTINGS.hold_time
    assert faster.duration - holds == pytest.approx((first.duration - holds) / FASTER, rel=0.02)
    with pytest.raises(NameNotFoundError, match=r"motion named 'dance' .*landmarks"):
        planner.plan(SUPPORTS[0], "dance")


@pytest.mark.parametrize("name", NAMES)
def test_from_measured_angles(name: str) -> None:
    """Encoders a little off: then the feet seem a little off one floor, and stay so."""
    planner, robot = planner_of(name), load_body(name).robot
    stance = planner.stance(SUPPORTS[0])
    generator = np.random.default_rng(5)
    measured = stance + generator.uniform(-0.015, 0.015, len(stance))
    for pair in robot.shared:
        measured[pair.joint] = pair.ratio * measured[pair.leader]
    motion = planner.plan_from(measured)
    np.testing.assert_allclose(motion.positions[0], measured, atol=1e-12)
    assert np.abs(motion.foot_pose.translation - [0.03, -0.125, 0.0]).max() > 5e-4
    assert check_motion(planner.legs, motion, SETTINGS).kept
    assert np.sum(motion.path.nearest < SETTINGS.landmark_radius) >= 3


def test_from_outside_the_margins() -> None:
    """A knee straighter than wanted is bent again, gently."""
    strict = dataclasses.replace(SETTINGS, knee_margin=0.86)
    robot = load_body("odd_biped").robot
    planner = Planner(robot, strict)
    column = planner.legs.knees[0].column
    start = planner_of("odd_biped").stance(SUPPORTS[0])
    lower, _ = planner.legs.bounds(strict)
    beyond = lower[column] - start[robot.legs[column]]
    assert beyond > 0.0
    motion = planner.plan_from(start)
    knee = motion.path.states[:, column]
    assert np.all(knee[5:] >= lower[column] - 1e-5)
    assert np.abs(np.diff(knee)).max() <= SETTINGS.joint_speed * SETTINGS.step_time + 1e-6


def test_standing_still_is_a_motion_too() -> None:
    planner, motion = planner_of("nao"), motion_of("nao")
    stay = dataclasses.replace(motion.path, states=motion.path.states[:1])
    segment = cop_segment("hold", np.zeros((0, 2)), motion.foot_pose, SETTINGS)
    still = timed(planner.legs, [(segment, stay)], "hold", planner.stance(SUPPORTS[0]), SETTINGS)
    np.testing.assert_allclose(still.positions - still.positions[0], 0.0, atol=1e-12)
    assert still.duration > 2.0 * SETTINGS.hold_time
    assert check_motion(planner.legs, still, SETTINGS).kept


def test_progress_and_cancel() -> None:
    told: list[Progress] = []

    def stop() -> bool:
        return len(told) >= 3

    with pytest.raises(PlanningCanceledError):
        planner_of("nao").plan(SUPPORTS[0], progress=told.append, canceled=stop)
    assert [entry.steps for entry in told] == [0, 2, 4]
    assert all(entry.landmarks == 5 for entry in told)


def test_starts_that_are_none() -> None:
    planner, robot = planner_of("nao"), load_body("nao").robot
    stance = planner.stance(SUPPORTS[0])
    lifted = stance.copy()
    lifted[robot.joint("RKneePitch")] += 0.6
    with pytest.raises(StartError, match="check the joint offsets"):
        planner.plan_from(lifted)
    leaning = stance.copy()
    for name in ("LAnklePitch", "RAnklePitch"):
        leaning[robot.joint(name)] += 0.4
    # Leaning forward lifts one of the soles a little: the feet stand one ahead of the other.
    with pytest.raises(StartError, match=r"outside the sensing polygon|above the other"):
        planner.plan_from(leaning)
    with pytest.raises(StartError, match="finite"):
        planner.plan_from(np.full_like(stance, np.nan))
    with pytest.raises(ShapeError, match="joint angles"):
        planner.plan_from(stance[:5])


def test_what_is_too_fast_is_done_more_slowly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Timing that takes its limits for higher than they are."""
    name = "odd_biped"
    paces: list[float] = []

    def optimistic(
        legs: Legs,
        parts: Sequence[tuple[MotionSegment, Path]],
        motion: str,
        others: np.ndarray,
        settings: PlannerSettings,
    ) -> Motion:
        paces.append(settings.com_speed / SETTINGS.com_speed)
        return timed(legs, parts, motion, others, settings.paced(1.3))

    monkeypatch.setattr("shoecal_core.planning.planner.timed", optimistic)
    motion = planner_of(name).plan(SUPPORTS[0])
    assert paces == sorted(paces, reverse=True)
    assert len(paces) > 1
    assert check_motion(planner_of(name).legs, motion, SETTINGS).kept
