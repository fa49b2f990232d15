from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np
import pinocchio as pin
import pytest
import shapely
from scipy.optimize import NonlinearConstraint, minimize

from core.planning.bodies import Body
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.horizon.collocation import RECOVERY, Collocation
from shoecal_core.planning.horizon.ipopt import IpoptSolver
from shoecal_core.planning.horizon.problem import Aim, HorizonProblem, Scene
from shoecal_core.planning.landmarks import Contour, sensing_hull
from shoecal_core.planning.legs import FootPose, LegExpressions, Legs
from shoecal_core.planning.posture import StanceSolver, middle
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.settings import SettingError

SETTINGS = PlannerSettings()
SUPPORT = DoubleSupport(0.02, -0.125, 0.15)


def scene_of(body: Body, support: DoubleSupport = SUPPORT) -> Scene:
    return Scene.of(
        sensing_hull(body.robot, support),
        SETTINGS.stability_margin,
        FootPose.of(support),
        body.robot.posture,
    )


def problem_of(body: Body, settings: PlannerSettings = SETTINGS) -> HorizonProblem:
    """From the stance towards the first landmark."""
    start = StanceSolver(body.legs, settings).solve(SUPPORT)
    target = Contour.of(body.robot, SUPPORT).corners[1]
    return HorizonProblem(start, np.zeros_like(start), Aim.at(target, SETTINGS), scene_of(body))


def random_legs(body: Body, count: int, seed: int = 0) -> FloatArray:
    generator = np.random.default_rng(seed)
    return body.legs.nominal + generator.uniform(-0.2, 0.2, (count, len(body.legs.nominal)))


@pytest.fixture(scope="module")
def collocation(body: Body) -> Collocation:
    return Collocation(body.legs, SETTINGS)


def test_state_values_by_pinocchio(body: Body, collocation: Collocation) -> None:
    states = random_legs(body, 20)
    values = collocation.evaluate(states, scene_of(body))
    seen = track(body.robot, body.robot.from_legs(states))
    np.testing.assert_allclose(values.cop, seen.com[:, :2], atol=1e-12)
    # The expression is smoothed: at most this much nearer, and never farther.
    np.testing.assert_array_less(values.distances, seen.distances + 1e-9)
    np.testing.assert_allclose(values.distances, seen.distances, atol=2e-6)


def test_torques_by_pinocchio(body: Body, collocation: Collocation) -> None:
    solver = StanceSolver(body.legs, SETTINGS)
    for support in (SUPPORT, DoubleSupport(-0.02, -0.14, -0.3)):
        for aside in ((0.0, 0.0), (0.01, 0.01), (-0.01, 0.02), (0.0, -0.03)):
            legs = solver.solve(support, middle(body.robot, support) + aside)[None]
            torques = collocation.evaluate(legs, scene_of(body, support)).torques
            expected = track(body.robot, body.robot.from_legs(legs)).torques
            np.testing.assert_allclose(np.abs(torques), np.abs(expected), atol=1e-6)


def test_foot_error_is_the_difference_of_poses(body: Body, collocation: Collocation) -> None:
    legs = StanceSolver(body.legs, SETTINGS).solve(SUPPORT)[None]
    error = collocation.evaluate(legs, scene_of(body)).foot_error[0]
    np.testing.assert_allclose(error, 0.0, atol=1e-7)
    way, turn = np.array([1e-3, -2e-3, 3e-3]), np.array([2e-3, 1e-3, -1e-3])
    pose = FootPose.of(SUPPORT)
    moved = FootPose(pose.rotation @ pin.exp3(turn).T, pose.translation - way)
    scene = dataclasses.replace(scene_of(body), foot_poses=moved.parameters[None])
    error = collocation.evaluate(legs, scene).foot_error[0]
    np.testing.assert_allclose(error[:3], way, atol=1e-7)
    np.testing.assert_allclose(error[3:], turn, atol=1e-7)


def test_derivatives_against_finite_differences(body: Body) -> None:
    terms = LegExpressions(body.robot)
    rows = ca.vertcat(
        terms.cop, terms.foot_error, terms.distances, terms.torques, terms.lean, terms.height
    )
    jacobian = ca.jacobian(rows, terms.angles)
    inputs = [terms.angles, terms.foot_pose, terms.others, terms.share]
    function = ca.Function("rows", inputs, [rows, jacobian])
    rest = (FootPose.of(SUPPORT).parameters, body.robot.posture, [0.0, 1.0])
    step = 1e-6
    for legs in random_legs(body, 3):
        exact = np.array(function(legs, *rest)[1])
        for index, unit in enumerate(np.eye(len(legs))):
            ahead, behind = (
                np.array(function(legs + way * step * unit, *rest)[0]).ravel() for way in (1, -1)
            )
            slope = (ahead - behind) / (2 * step)
            np.testing.assert_allclose(exact[:, index], slope, atol=2e-6)


def test_cost_is_equation_nine(body: Body, collocation: Collocation) -> None:
    problem = problem_of(body)
    problem = dataclasses.replace(problem, previous=np.full_like(problem.start, 0.01))
    states = random_legs(body, SETTINGS.horizon)
    cost, before, previous = 0.0, problem.start, problem.previous
    for state in states:
        cop = body.legs.cop(body.robot.from_legs(state)[None])[0]
        move = state - before
        cost += SETTINGS.cop_weight_x * (cop[0] - problem.aim.targets[0, 0]) ** 2
        cost += SETTINGS.cop_weight_y * (cop[1] - problem.aim.targets[0, 1]) ** 2
        cost += SETTINGS.transition_weight * float(np.sum((move - previous) ** 2))
        before, previous = state, move
    limits = collocation.limits(problem)
    assert collocation.assess(problem, limits, states)[0] == pytest.approx(cost)


def test_half_planes_are_the_shrunk_polygon(body: Body) -> None:
    scene = scene_of(body)
    shrunk = sensing_hull(body.robot, SUPPORT).buffer(-SETTINGS.stability_margin)
    points = np.random.default_rng(0).uniform((-0.1, -0.25), (0.15, 0.1), (500, 2))
    inside = np.all(points @ scene.normals[0].T <= scene.offsets[0], axis=1)
    np.testing.assert_array_equal(inside, shapely.contains_xy(shrunk, points))
    assert 20 < inside.sum() < 480


def test_margin_larger_than_the_polygon() -> None:
    square = shapely.box(0.0, 0.0, 0.1, 0.1)
    with pytest.raises(SettingError, match="stability_margin"):
        Scene.of(square, 0.06, FootPose.of(SUPPORT), np.zeros(3))


def test_bounds_lead_a_start_back_inside(body: Body, collocation: Collocation) -> None:
    problem = problem_of(body)
    limits = collocation.limits(problem)
    assert np.all(limits.lower == collocation.lower)
    assert np.all(limits.upper == collocation.upper)
    outside = problem.start.copy()
    outside[0] = collocation.upper[0] + 0.02
    bound = collocation.limits(dataclasses.replace(problem, start=outside)).upper[:, 0]
    step = RECOVERY * collocation.transition[0]
    assert bound[0] == pytest.approx(outside[0] - step)
    assert np.all(np.diff(bound) <= 0.0)
    assert bound[-1] == collocation.upper[0]


def test_ipopt_solves_and_certifies(body: Body, collocation: Collocation) -> None:
    problem = problem_of(body)
    solver = IpoptSolver(collocation)
    solution = solver.solve(problem, np.tile(problem.start, (SETTINGS.horizon, 1)))
    assert solution.converged
    assert solution.violation < 1e-7
    limits = collocation.limits(problem)
    assert (solution.cost, solution.violation) == collocation.assess(
        problem, limits, solution.states
    )
    still = np.tile(problem.start, (SETTINGS.horizon, 1))
    assert solution.cost < 0.8 * collocation.assess(problem, limits, still)[0]
    seen = track(body.robot, body.robot.from_legs(solution.states))
    np.testing.assert_allclose(
        seen.right_translation, np.tile([SUPPORT.dx, SUPPORT.dy, 0.0], (10, 1)), atol=1e-7
    )
    moves = np.abs(collocation.transitions(problem, solution.states))
    assert np.all(moves <= SETTINGS.joint_speed * SETTINGS.step_time + 1e-7)
    # The same object serves another support.
    other = DoubleSupport(-0.02, -0.14, -0.3)
    start = StanceSolver(body.legs, SETTINGS).solve(other)
    target = Contour.of(body.robot, other).corners[3]
    again = HorizonProblem(
        start, np.zeros_like(start), Aim.at(target, SETTINGS), scene_of(body, other)
    )
    assert solver.solve(again, np.tile(start, (SETTINGS.horizon, 1))).converged


def test_ipopt_agrees_with_a_second_method(nao: Body) -> None:
    settings = dataclasses.replace(SETTINGS, horizon=2)
    collocation = Collocation(nao.legs, settings)
    problem = problem_of(nao, settings)
    scene, limits = problem.scene, collocation.limits(problem)
    shape = limits.lower.shape
    guess = np.tile(problem.start, (2, 1))
    found = IpoptSolver(collocation).solve(problem, guess)

    def feet(flat: FloatArray) -> FloatArray:
        return collocation.evaluate(flat.reshape(shape), scene).foot_error.ravel()

    def room(flat: FloatArray) -> FloatArray:
        states = flat.reshape(shape)
        values = collocation.evaluate(states, scene)
        moves = collocation.transitions(problem, states)
        return np.concatenate(
            [
                (limits.offsets - scene.beyond(values.cop)).ravel(),
                (values.distances - limits.clearances).ravel(),
                (limits.torque - np.abs(values.torques)).ravel(),
                (limits.transition - np.abs(moves)).ravel(),
            ]
        )

    second = minimize(  # type: ignore[call-overload]  # its stubs know no tuples of bounds
        lambda flat: collocation.assess(problem, limits, flat.reshape(shape))[0],
        guess.ravel(),
        method="SLSQP",
        bounds=list(zip(limits.lower.ravel(), limits.upper.ravel(), strict=True)),
        constraints=[NonlinearConstraint(feet, 0.0, 0.0), NonlinearConstraint(room, 0.0, np.inf)],
        tol=1e-8,
    )
    assert found.converged
    assert found.cost == pytest.approx(second.fun, rel=1e-4)


def test_a_start_outside_a_margin_is_led_back(nao: Body) -> None:
    """InitialStance with an ankle nearer to its limit than the margin."""
    loose = dataclasses.replace(SETTINGS, joint_margin=0.005, stance_margin=0.0)
    support = DoubleSupport(0.0, -0.13, 0.1)
    target = Contour.of(nao.robot, support).midpoints[3]
    start = StanceSolver(nao.legs, loose).solve(support, target)
    strict = dataclasses.replace(SETTINGS, joint_margin=0.05)
    collocation = Collocation(nao.legs, strict)
    column = int(np.argmax(collocation.lower - start))
    start[column] = min(start[column], collocation.lower[column] - 0.004)
    pose = nao.legs.foot_pose(nao.robot.from_legs(start))
    scene = dataclasses.replace(scene_of(nao, support), foot_poses=pose.parameters[None])
    problem = HorizonProblem(start, np.zeros_like(start), Aim.at(target, SETTINGS), scene)
    solution = IpoptSolver(collocation).solve(problem, np.tile(start, (strict.horizon, 1)))
    assert solution.converged
    assert solution.states[-1, column] >= collocation.lower[column] - 1e-6
    assert np.all(np.diff(solution.states[:2, column]) >= 0.0)


def test_no_pairs_no_distances(nao: Body) -> None:
    bare = dataclasses.replace(nao.robot, collision_pairs=())
    body = Body(bare, nao.shoe, Legs(bare))
    collocation = Collocation(body.legs, SETTINGS)
    problem = problem_of(body)
    assert collocation.evaluate(problem.start[None], problem.scene).distances.shape == (1, 0)
    solver = IpoptSolver(collocation)
    assert solver.solve(problem, np.tile(problem.start, (10, 1))).converged
    assert track(bare, bare.posture[None]).distances.shape == (1, 0)


def test_what_a_start_does_not_keep_is_told(nao: Body) -> None:
    problem = problem_of(nao)
    collocation = Collocation(nao.legs, SETTINGS)
    assert collocation.outside(problem.start, problem.scene) == ()
    column = nao.robot.leg_names.index("LKneePitch")
    straight = problem.start.copy()
    straight[column] = collocation.lower[column] - 0.1
    (told,) = (
        line for line in collocation.outside(straight, problem.scene) if "LKneePitch" in line
        and "joint" in line
    )  # fmt: skip
    assert "0.100 rad" in told
    strict = dataclasses.replace(SETTINGS, capsule_clearance=0.2, torque_share=0.01)
    told_all = Collocation(nao.legs, strict).outside(problem.start, problem.scene)
    assert sum("capsules" in line for line in told_all) == len(nao.robot.collision_pairs)
    assert any("motor 'LKneePitch' holds" in line for line in told_all)
    far = dataclasses.replace(problem.scene, offsets=problem.scene.offsets - 0.2)
    assert any(
        "mm beyond stability_margin" in line for line in collocation.outside(problem.start, far)
    )
