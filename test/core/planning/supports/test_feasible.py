from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.planning.bodies import Body
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible, feet_distance, support_grid
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.standing import feet_gap

SETTINGS = PlannerSettings()


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


def test_far_landmarks_rule_supports_out(nao: Body) -> None:
    """There the robot can stand, but not above three of its landmarks."""
    far = DoubleSupport(0.08, -0.16, -0.52)
    assert not Feasible(nao.robot, SETTINGS).can_stand(far)
    easier = dataclasses.replace(SETTINGS, landmarks_in_reach=0)
    assert Feasible(nao.robot, easier).can_stand(far)


def test_apart_is_all_that_may_be_drawn(body: Body) -> None:
    feasible = Feasible(body.robot, SETTINGS)
    apart = feasible.apart()
    assert len(set(apart)) == len(apart)
    for support in apart:
        assert feet_gap(body.robot, support) >= SETTINGS.foot_clearance
        way = np.array([support.dx, support.dy])
        assert feet_distance(way, support.dtheta, SETTINGS) > SETTINGS.distance_min
    drawn = next(feasible.draw(np.random.default_rng(0)))
    assert drawn in apart
    assert feasible.can_stand(drawn)


def test_own_steps_need_supports_on_one_foot(nao: Body) -> None:
    """Wide ones can be stood on, but no foot lifted there."""
    wide = DoubleSupport(-0.01, -0.16, 0.312)
    assert Feasible(nao.robot, SETTINGS).can_stand(wide)
    stepping = dataclasses.replace(SETTINGS, one_foot=True)
    assert not Feasible(nao.robot, stepping).can_stand(wide)
    assert Feasible(nao.robot, stepping).can_stand(DoubleSupport(0.0, -0.112, 0.0))
