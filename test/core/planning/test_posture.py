from __future__ import annotations

import dataclasses
import pickle

import numpy as np
import pinocchio as pin
import pytest

from core.planning.bodies import Body, load_body
from shoecal_core.planning.landmarks import Contour
from shoecal_core.planning.legs import FootPose, Legs
from shoecal_core.planning.posture import (
    FeetOverlapError,
    StanceSolver,
    UnreachableError,
    middle,
    stance,
)
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.standing import feet_gap
from shoecal_core.settings import SettingError

SETTINGS = PlannerSettings()


def random_supports(body: Body, count: int) -> list[DoubleSupport]:
    span = body.robot.support_range
    draws = np.random.default_rng(2).uniform(span.lower, span.upper, (4 * count, 3))
    supports = [DoubleSupport(*(float(value) for value in draw)) for draw in draws]
    return [support for support in supports if feet_gap(body.robot, support) > 0.0][:count]


def test_feet_com_and_limits_by_pinocchio(body: Body) -> None:
    robot = body.robot
    solver = StanceSolver(body.legs, SETTINGS)
    data = robot.model.createData()
    lower, upper = body.legs.bounds(SETTINGS, SETTINGS.stance_margin)
    for support in random_supports(body, 12):
        legs = solver.solve(support)
        assert np.all((legs >= lower) & (legs <= upper))
        base = np.concatenate([[0, 0, 0, 0, 0, 0, 1.0], robot.from_legs(legs)])
        com = pin.centerOfMass(robot.model, data, base)
        pin.updateFramePlacements(robot.model, data)
        left, right = (data.oMf[foot.frame] for foot in robot.feet)
        between = left.actInv(right)
        expected = pin.SE3(
            pin.rpy.rpyToMatrix(0, 0, support.dtheta), np.array([support.dx, support.dy, 0.0])
        )
        np.testing.assert_allclose(between.homogeneous, expected.homogeneous, atol=1e-6)
        np.testing.assert_allclose(left.actInv(com)[:2], middle(robot, support), atol=1e-6)
        up = left.rotation.T[:, 2]
        assert up[2] > np.cos(0.25), "the torso stands upright"


def test_what_is_found_near_is_there_by_pinocchio_and_by_the_solver(body: Body) -> None:
    solver, posture = StanceSolver(body.legs, SETTINGS), body.robot.posture
    lower, upper = body.legs.bounds(SETTINGS, SETTINGS.stance_margin)
    reached = 0
    for support in random_supports(body, 6):
        legs, centre = solver.near(support), middle(body.robot, support)
        assert np.all((legs >= lower) & (legs <= upper))
        np.testing.assert_allclose(
            body.legs.foot_pose(body.robot.from_legs(legs)).translation,
            [support.dx, support.dy, 0.0],
            atol=1e-6,
        )
        cop = body.legs.cop(body.robot.from_legs(legs)[None])[0]
        np.testing.assert_allclose(cop, centre, atol=1e-6)
        pose, corners = FootPose.of(support), Contour.of(body.robot, support).corners
        places = solver.within_reach(pose, corners, posture)
        for corner, place in zip(corners, places, strict=True):
            if solver.reaches(pose, corner, 0.45, legs):
                reached += 1
                whole = np.linalg.norm(centre - corner)
                assert np.linalg.norm(place - corner) <= 0.5 * whole
    assert reached > 12


def test_a_place_for_the_cop(body: Body) -> None:
    neutral = DoubleSupport(0.0, -0.13, 0.1)
    target = Contour.of(body.robot, neutral).midpoints[1]
    legs = StanceSolver(body.legs, SETTINGS).solve(neutral, target)
    cop = body.legs.cop(body.robot.from_legs(legs)[None])[0]
    np.testing.assert_allclose(cop, target, atol=1e-6)


@pytest.mark.parametrize("share", [0.167, 0.165])
def test_motors_at_their_limit_hold_a_heavy_robot_as_they_hold_a_light_one(
    nao: Body, share: float
) -> None:
    light, times = nao.robot, 400.0
    heavy = dataclasses.replace(light, model=light.model.copy(), mass=times * light.mass)
    heavy.model.effortLimit = times * np.minimum(light.model.effortLimit, 1e3)
    for index, link in enumerate(light.model.inertias):
        heavy.model.inertias[index] = pin.Inertia(
            times * link.mass, link.lever, times * link.inertia
        )
    support = DoubleSupport(0.03, -0.12, 0.2)
    strained = dataclasses.replace(SETTINGS, torque_share=share)
    expected = StanceSolver(nao.legs, strained).solve(support)
    assert np.abs(expected - StanceSolver(nao.legs, SETTINGS).solve(support)).max() > 1e-3
    found = StanceSolver(Legs(heavy), strained).solve(support)
    np.testing.assert_allclose(found, expected, atol=1e-5)


def test_one_call_gives_the_same(nao: Body) -> None:
    support = DoubleSupport(0.03, -0.12, 0.2)
    once = stance(nao.robot, support)
    np.testing.assert_array_equal(once, StanceSolver(nao.legs, SETTINGS).solve(support))


def test_out_of_reach(body: Body) -> None:
    far = DoubleSupport(0.7, -0.12, 0.0)
    with pytest.raises(UnreachableError, match=r"dx 0\.7 m") as caught:
        StanceSolver(body.legs, SETTINGS).solve(far)
    assert caught.value.support == far


def test_margins_without_room_are_refused(body: Body) -> None:
    tight = dataclasses.replace(SETTINGS, joint_margin=1.2)
    with pytest.raises(SettingError, match=r"joint_margin: .* no room"):
        body.legs.bounds(tight)


def test_one_foot_on_the_other(body: Body) -> None:
    with pytest.raises(
        FeetOverlapError, match=r"overlap .* dy -0\.05 m.*; choose a place"
    ) as caught:
        StanceSolver(body.legs, SETTINGS).solve(DoubleSupport(0.0, -0.05, 0.0))
    assert caught.value.support.dy == -0.05
    assert pickle.loads(pickle.dumps(caught.value)).support == caught.value.support


@pytest.mark.parametrize("name", ["nao", "wren", "odd_biped"])
def test_knees_are_found_and_kept_bent(name: str) -> None:
    body = load_body(name)
    names = [body.robot.leg_names[knee.column] for knee in body.legs.knees]
    assert all("knee" in name.lower() for name in names)
    assert names[0] != names[1]
    lower, upper = body.legs.bounds(SETTINGS)
    for knee in body.legs.knees:
        assert knee.straight == pytest.approx(0.0, abs=0.05)
        bent = np.sign(body.legs.nominal[knee.column])
        bound = lower if bent > 0.0 else upper
        assert bound[knee.column] == pytest.approx(knee.straight + bent * SETTINGS.knee_margin)
