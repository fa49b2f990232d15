from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from shoecal_core.planning.capsules import segment_distance, segment_distance_squared

Points = NDArray[np.float64]

coordinate = st.floats(-1.0, 1.0).map(lambda value: round(value, 3))
point = st.tuples(coordinate, coordinate, coordinate).map(np.array)
segments = st.tuples(point, point, point, point)


def by_quadratic_programme(a0: Points, a1: Points, b0: Points, b1: Points) -> float:
    """|a0 + s (a1 - a0) - b0 - t (b1 - b0)| least over 0 <= s, t <= 1."""
    matrix = np.column_stack([a1 - a0, b0 - b1])
    result = lsq_linear(matrix, b0 - a0, bounds=(0.0, 1.0), tol=1e-14, method="bvls")
    return float(np.linalg.norm(matrix @ result.x - (b0 - a0)))


def expression() -> ca.Function:
    ends = [ca.SX.sym(name, 3) for name in ("a0", "a1", "b0", "b1")]
    return ca.Function("distance", ends, [segment_distance_squared(*ends)])


DISTANCE_SQUARED = expression()


@given(segments)
def test_numpy_agrees_with_a_quadratic_programme(ends: tuple[Points, ...]) -> None:
    assert segment_distance(*ends) == pytest.approx(by_quadratic_programme(*ends), abs=1e-7)


@given(segments)
def test_expression_agrees_with_numpy(ends: tuple[Points, ...]) -> None:
    squared = float(DISTANCE_SQUARED(*ends))
    assert np.sqrt(squared) == pytest.approx(float(segment_distance(*ends)), abs=1e-6)


@given(segments, st.floats(-2.0, 2.0), point)
def test_parallel_segments(ends: tuple[Points, ...], stretch: float, shift: Points) -> None:
    a0, a1 = ends[:2]
    b0, b1 = a0 + shift, a0 + shift + stretch * (a1 - a0)
    expected = by_quadratic_programme(a0, a1, b0, b1)
    assert segment_distance(a0, a1, b0, b1) == pytest.approx(expected, abs=1e-7)
    assert np.sqrt(float(DISTANCE_SQUARED(a0, a1, b0, b1))) == pytest.approx(expected, abs=1e-6)


@given(point, point, point)
def test_a_point_is_a_segment(place: Points, start: Points, end: Points) -> None:
    expected = by_quadratic_programme(place, place, start, end)
    assert segment_distance(place, place, start, end) == pytest.approx(expected, abs=1e-7)
    for order in ((place, place, start, end), (start, end, place, place)):
        assert np.sqrt(float(DISTANCE_SQUARED(*order))) == pytest.approx(expected, abs=1e-6)


def test_known_distances() -> None:
    x, y, z = np.eye(3)
    zero = np.zeros(3)
    crossing = segment_distance(-x, x, z - y, z + y)
    behind = segment_distance(zero, x, 3 * x, 4 * x)
    touching = segment_distance(zero, x, x, y)
    assert [float(crossing), float(behind), float(touching)] == pytest.approx([1.0, 2.0, 0.0])


def test_works_on_batches() -> None:
    generator = np.random.default_rng(1)
    ends = generator.normal(size=(4, 7, 5, 3))
    batch = segment_distance(*ends)
    assert batch.shape == (7, 5)
    one = segment_distance(*(part[3, 2] for part in ends))
    assert batch[3, 2] == one


@given(segments)
def test_expression_gradient_against_finite_differences(ends: tuple[Points, ...]) -> None:
    symbols = ca.SX.sym("ends", 12)
    squared = segment_distance_squared(*ca.vertsplit(symbols, 3))
    gradient = ca.Function("gradient", [symbols], [squared, ca.gradient(squared, symbols)])
    place = np.concatenate(ends)
    direction = np.random.default_rng(0).normal(size=12)
    step = 1e-6
    ahead, behind = (float(gradient(place + way * step * direction)[0]) for way in (1, -1))
    slope = float(np.array(gradient(place)[1]).ravel() @ direction)
    here = float(gradient(place)[0])
    # On a kink (parallel or touching ends) only the one-sided slopes bracket the gradient.
    sides = sorted([(ahead - here) / step, (here - behind) / step])
    assert sides[0] - 1e-4 <= slope <= sides[1] + 1e-4
