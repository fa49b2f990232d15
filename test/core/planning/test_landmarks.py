from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from core.planning.bodies import Body
from shoecal_core.planning.landmarks import Contour, foot_landmarks, sensing_hull
from shoecal_core.robot.double_support import DoubleSupport


def test_rectangle() -> None:
    corners = np.array([[0.08, -0.03], [0.08, 0.05], [-0.04, 0.05], [-0.04, -0.03]])
    np.testing.assert_allclose(foot_landmarks(corners), [[0.05, 0.01], [-0.01, 0.01]], atol=1e-12)


@given(st.floats(0.02, 0.3), st.floats(0.01, 0.1), st.floats(0.01, 0.1), st.floats(-0.02, 0.02))
def test_trapezoid(length: float, front: float, rear: float, shift: float) -> None:
    """Widths 2 * front and 2 * rear, the front edge's middle moved sideways by `shift`."""
    corners = np.array(
        [[length, shift - front], [length, shift + front], [0.0, rear], [0.0, -rear]]
    )
    expected = [[0.75 * length, 0.75 * shift], [0.25 * length, 0.25 * shift]]
    np.testing.assert_allclose(foot_landmarks(corners), expected, atol=1e-12)


def test_contour_of_parallel_feet(body: Body) -> None:
    support = DoubleSupport(0.0, -0.14, 0.0)
    left, right = (foot_landmarks(foot.sensing_polygon) for foot in body.robot.feet)
    corners = Contour.of(body.robot, support).corners
    expected = [right[1] + [0, -0.14], right[0] + [0, -0.14], left[0], left[1]]
    np.testing.assert_allclose(corners, expected, atol=1e-12)


supports = st.builds(
    DoubleSupport, st.floats(-0.05, 0.08), st.floats(-0.18, -0.1), st.floats(-0.5, 0.5)
)


@given(supports)
def test_contour_is_counter_clockwise_within_the_hull(nao: Body, support: DoubleSupport) -> None:
    contour = Contour.of(nao.robot, support)
    ring = shapely.LinearRing(contour.corners)
    assert ring.is_ccw
    assert ring.is_simple
    assert sensing_hull(nao.robot, support).buffer(1e-9).contains(shapely.Polygon(ring))


@given(supports, st.integers(0, 3), st.floats(-0.003, 0.003), st.floats(-0.003, 0.003))
def test_targets_begin_at_the_nearest_midpoint(
    nao: Body, support: DoubleSupport, side: int, dx: float, dy: float
) -> None:
    contour = Contour.of(nao.robot, support)
    start = contour.midpoints[side]
    targets = contour.targets(start + np.array([dx, dy]))
    assert targets.shape == (5, 2)
    np.testing.assert_allclose(targets[0], start)
    np.testing.assert_allclose(targets[1], contour.corners[(side + 1) % 4])
    np.testing.assert_allclose(targets[-1], contour.corners[side])
    assert shapely.LinearRing(targets[1:]).is_ccw


def test_hull_of_parallel_rectangles(body: Body) -> None:
    support = DoubleSupport(0.0, -0.14, 0.0)
    left, right = (foot.sensing_polygon for foot in body.robot.feet)
    hull = sensing_hull(body.robot, support)
    assert hull.bounds[3] == pytest.approx(left[:, 1].max())
    assert hull.bounds[1] == pytest.approx(right[:, 1].min() - 0.14)
