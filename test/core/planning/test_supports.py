from __future__ import annotations

import contextlib
import dataclasses
import itertools

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from core.planning.bodies import Body
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.planning.landmarks import Contour
from shoecal_core.planning.observability import Visit, best_rank, information, rank
from shoecal_core.planning.posture import StanceSolver, UnreachableError
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports import (
    SupportRangeError,
    UnobservableError,
    draw_supports,
    feet_distance,
    feet_gap,
    support_grid,
)

SETTINGS = PlannerSettings()
QUICK = PlannerSettings(support_pool=6, landmarks_in_reach=0, support_redraws=5)
"""Fewer postures to find; what they are found for is tested with SETTINGS."""


def narrowed(robot: Robot, **changes: tuple[float, float, float]) -> Robot:
    span = dataclasses.replace(
        robot.support_range, **{key: np.array(value) for key, value in changes.items()}
    )
    return dataclasses.replace(robot, support_range=span)


@given(st.floats(-0.3, 0.3), st.floats(-0.3, 0.3), st.floats(-1.0, 1.0))
def test_distance_is_the_papers(dx: float, dy: float, dtheta: float) -> None:
    settings = dataclasses.replace(SETTINGS, distance_weight=2.0, orientation_weight=0.3)
    expected = 2.0 * (dx**2 + dy**2) ** 0.5 + 0.3 * abs(dtheta)
    assert feet_distance(np.array([dx, dy]), dtheta, settings) == pytest.approx(expected)


def test_gap_of_feet_side_by_side(body: Body) -> None:
    left, right = (foot.outline for foot in body.robot.feet)
    wide = 0.02 + right[:, 1].max() - left[:, 1].min()
    assert feet_gap(body.robot, DoubleSupport(0.0, -wide, 0.0)) == pytest.approx(0.02)
    assert feet_gap(body.robot, DoubleSupport(0.0, -wide + 0.03, 0.0)) == 0.0


def test_grid_covers_the_range(nao: Body) -> None:
    grid, span = support_grid(nao.robot), nao.robot.support_range
    np.testing.assert_allclose(grid.min(axis=0), span.lower)
    np.testing.assert_allclose(grid.max(axis=0), span.upper)
    assert len(grid) == 13 * 10 * 21


def test_every_draw_passes_every_check(body: Body) -> None:
    robot, span = body.robot, body.robot.support_range
    supports = draw_supports(robot, body.shoe, SETTINGS, 5, 3)
    assert len(set(supports)) == 5
    solver = StanceSolver(body.legs, SETTINGS)
    for support in supports:
        values = np.array([support.dx, support.dy, support.dtheta])
        steps = (values - span.lower) / span.step
        np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
        assert np.all((values >= span.lower - 1e-9) & (values <= span.upper + 1e-9))
        d = np.hypot(support.dx, support.dy) + 0.1 * abs(support.dtheta)
        assert d > SETTINGS.distance_min
        left, right = (shapely.Polygon(foot.outline) for foot in robot.feet)
        placed = shapely.affinity.translate(
            shapely.affinity.rotate(right, support.dtheta, origin=(0, 0), use_radians=True),
            support.dx,
            support.dy,
        )
        assert left.distance(placed) >= SETTINGS.foot_clearance - 1e-9
        solver.solve(support)
        assert landmarks_in_reach(body, solver, support) >= SETTINGS.landmarks_in_reach
    possible = best_rank(robot, body.shoe, 3, SETTINGS)
    for chosen in itertools.combinations(supports, 3):
        visits = [Visit.expected(robot, support, SETTINGS) for support in chosen]
        total = sum(information(robot, body.shoe, visit, SETTINGS) for visit in visits)
        assert rank(np.asarray(total), SETTINGS) == possible
    yaws = [support.dtheta for support in supports]
    assert max(yaws) - min(yaws) > 0.2


def landmarks_in_reach(body: Body, solver: StanceSolver, support: DoubleSupport) -> int:
    found = 0
    for landmark in Contour.of(body.robot, support).corners:
        with contextlib.suppress(UnreachableError):
            solver.solve(support, landmark)
            found += 1
    return found


def test_a_seed_tells_the_draw(nao: Body) -> None:
    first, again, other = (draw_supports(nao.robot, nao.shoe, QUICK, 2, seed) for seed in (1, 1, 2))
    assert first == again
    assert first != other


def test_far_landmarks_rule_supports_out(nao: Body) -> None:
    """There the robot can stand, but not above three of its landmarks."""
    far = DoubleSupport(0.08, -0.16, 0.416)
    solver = StanceSolver(nao.legs, SETTINGS)
    solver.solve(far)
    assert landmarks_in_reach(nao, solver, far) < 3
    place = (far.dx, far.dy, far.dtheta)
    with pytest.raises(SupportRangeError, match="0 of 1"):
        draw_supports(narrowed(nao.robot, lower=place, upper=place), nao.shoe, SETTINGS, 1, 0)


def test_yaw_that_never_differs_is_refused(body: Body) -> None:
    span = body.robot.support_range
    flat = narrowed(
        body.robot,
        lower=(span.lower[0], span.lower[1], 0.0),
        upper=(span.upper[0], span.upper[1], 0.0),
    )
    with pytest.raises(UnobservableError, match="dtheta_rad") as caught:
        draw_supports(flat, body.shoe, QUICK, 5, 0)
    assert caught.value.rank < caught.value.possible == 14


def test_ranges_too_small_are_refused(nao: Body) -> None:
    one = narrowed(nao.robot, lower=(0.0, -0.12, 0.1), upper=(0.0, -0.12, 0.1))
    assert draw_supports(one, nao.shoe, SETTINGS, 1, 0) == [DoubleSupport(0.0, -0.12, 0.1)]
    with pytest.raises(SupportRangeError, match=r"1 of 2 double supports .* widen"):
        draw_supports(one, nao.shoe, SETTINGS, 2, 0)
    colliding = narrowed(nao.robot, lower=(0.0, -0.06, 0.0), upper=(0.0, -0.06, 0.0))
    with pytest.raises(SupportRangeError, match="0 of 1"):
        draw_supports(colliding, nao.shoe, SETTINGS, 1, 0)
    with pytest.raises(SupportRangeError, match="at least one"):
        draw_supports(nao.robot, nao.shoe, SETTINGS, 0, 0)
