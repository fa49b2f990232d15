from __future__ import annotations

import contextlib
import dataclasses
import itertools

import numpy as np
import pytest
import shapely

from core.planning.bodies import Body, load_body
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.landmarks import Contour
from shoecal_core.planning.posture import StanceSolver, UnreachableError, middle
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import (
    UnobservableError,
    draw_supports,
    other_supports,
    weakest_rank,
)
from shoecal_core.planning.supports.feasible import Feasible, SupportRangeError
from shoecal_core.planning.supports.observability import Visit, best_rank, information, rank
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot

SETTINGS = PlannerSettings()
QUICK = PlannerSettings(support_pool=6, landmarks_in_reach=0)
"""Fewer postures to find; what they are found for is tested with SETTINGS."""


def narrowed(robot: Robot, **changes: tuple[float, float, float]) -> Robot:
    span = dataclasses.replace(
        robot.support_range, **{key: np.array(value) for key, value in changes.items()}
    )
    return dataclasses.replace(robot, support_range=span)


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
        total = sum(information(robot, body.shoe, visit) for visit in visits)
        assert rank(np.asarray(total), SETTINGS) == possible
    yaws = [support.dtheta for support in supports]
    assert max(yaws) - min(yaws) > 0.2


def landmarks_in_reach(body: Body, solver: StanceSolver, support: DoubleSupport) -> int:
    """Or places half the way in from them."""
    found, centre = 0, middle(body.robot, support)
    for landmark in Contour.of(body.robot, support).corners:
        with contextlib.suppress(UnreachableError):
            solver.solve(support, landmark + 0.5 * (centre - landmark))
            found += 1
    return found


def test_a_seed_tells_the_draw(nao: Body) -> None:
    first, again, other = (draw_supports(nao.robot, nao.shoe, QUICK, 2, seed) for seed in (1, 1, 2))
    assert first == again
    assert first != other


def test_supports_out_of_reach_are_none(nao: Body) -> None:
    place = (0.08, -0.16, -0.52)
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
    assert caught.value.rank < caught.value.possible


def test_where_not_any_three_fix_all_the_first_three_do(nao: Body) -> None:
    """Of five double supports at two yaws, two of one: leave these out, and the yaw is one."""
    robot, span = nao.robot, nao.robot.support_range
    yaw = 0.5 * float(span.upper[2] - span.lower[2])
    two = dataclasses.replace(
        robot, support_range=dataclasses.replace(span, step=np.array([*span.step[:2], yaw]))
    )
    settings = dataclasses.replace(SETTINGS, support_pool=6, fixed_below=0.4)
    supports = draw_supports(two, nao.shoe, settings, 5, 0)
    possible = best_rank(two, nao.shoe, 3, settings)
    visits = [Visit.expected(two, support, settings) for support in supports]
    parts = [information(two, nao.shoe, visit) for visit in visits]
    assert rank(np.sum(parts[:3], axis=0), settings) == possible
    assert weakest_rank(parts, settings) < possible


def test_a_robot_that_can_hardly_stand_is_given_up_by_the_likely_cause() -> None:
    """Its motors hardly carry it."""
    wren = load_body("wren")
    model = wren.robot.model.copy()
    model.effortLimit = 0.1 * model.effortLimit
    weak = dataclasses.replace(wren.robot, model=model)
    settings = dataclasses.replace(SETTINGS, support_pool=2)
    told: list[tuple[int, int]] = []
    with pytest.raises(SupportRangeError, match=r"would need .* N m more") as caught:
        draw_supports(weak, wren.shoe, settings, 2, 0, lambda *tried: told.append(tried))
    tally = caught.value.tally
    assert told[0][0] == 0
    assert {most for _, most in told} == {tally.unreachable + tally.landmarks + tally.usable}


def test_ranges_too_small_are_refused(nao: Body) -> None:
    one = narrowed(nao.robot, lower=(0.0, -0.12, 0.1), upper=(0.0, -0.12, 0.1))
    assert draw_supports(one, nao.shoe, SETTINGS, 1, 0) == [DoubleSupport(0.0, -0.12, 0.1)]
    with pytest.raises(SupportRangeError, match=r"1 of 2 double supports .* widen"):
        draw_supports(one, nao.shoe, SETTINGS, 2, 0)
    colliding = narrowed(nao.robot, lower=(0.0, -0.06, 0.0), upper=(0.0, -0.06, 0.0))
    with pytest.raises(
        SupportRangeError, match=r"0 of 1 .* 1 with feet too near, .* lower distance"
    ):
        draw_supports(colliding, nao.shoe, SETTINGS, 1, 0)
    with pytest.raises(ShoecalError, match="at least one"):
        draw_supports(nao.robot, nao.shoe, SETTINGS, 0, 0)


def test_others_are_usable_few_and_the_same_for_a_seed(nao: Body) -> None:
    taken = draw_supports(nao.robot, nao.shoe, QUICK, 1, 5)
    first, second = (
        list(itertools.islice(other_supports(nao.robot, QUICK, taken, 5), 2)) for _ in range(2)
    )
    assert first == second
    assert len({*first, *taken}) == 3
    feasible = Feasible(nao.robot, QUICK)
    assert all(feasible.can_stand(support) for support in first)
    assert first[1:] == list(itertools.islice(other_supports(nao.robot, QUICK, first[:1], 5), 1))


def test_where_there_are_no_others_the_search_ends(nao: Body) -> None:
    place = (0.08, -0.16, -0.52)
    tight = narrowed(nao.robot, lower=place, upper=place)
    assert list(other_supports(tight, SETTINGS, (), 1)) == []
