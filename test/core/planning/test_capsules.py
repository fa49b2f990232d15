from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.capsules import (
    SOFTNESS,
    segment_distance,
    segment_distance_squared,
)

Points = FloatArray

coordinate = st.floats(-1.0, 1.0).map(lambda value: round(value, 3))
point = st.tuples(coordinate, coordinate, coordinate).map(np.array)
segments = st.tuples(point, point, point, point)


def by_quadratic_programme(a0: Points, a1: Points, b0: Points, b1: Points) -> float:
    """|a0 + s (a1 - a0) - b0 - t (b1 - b0)| least over 0 <= s, t <= 1."""
    matrix = np.column_stack([a1 - a0, b0 - b1])
    result = lsq_linear(matrix, b0 - a0, bounds=(0.0, 1.0), tol=1e-14, method="bvls")
    return float(np.linalg.norm(matrix @ result.x - (b0 - a0)))


def functions() -> list[ca.Function]:
    """Of all ends (12,): squared distance, its gradient (12, 1), its second derivatives."""
    ends = ca.SX.sym("ends", 12)
    squared = segment_distance_squared(*ca.vertsplit(ends, 3))
    second, first = ca.hessian(squared, ends)
    rows = {"value": squared, "gradient": first, "hessian": second}
    return [ca.Function(name, [ends], [row]) for name, row in rows.items()]


VALUE, GRADIENT, HESSIAN = functions()


def smoothed(*ends: Points) -> float:
    return float(VALUE(np.concatenate(ends)))


def gradient(*ends: Points) -> Points:
    return np.array(GRADIENT(np.concatenate(ends))).ravel()


def agrees(*ends: Points) -> bool:
    """The expression is the squared distance or less by what its smoothing may take."""
    exact = float(segment_distance(*ends)) ** 2
    mean = (np.sum((ends[1] - ends[0]) ** 2) + np.sum((ends[3] - ends[2]) ** 2)) / 2.0
    return bool(-SOFTNESS * mean / 2.0 - 1e-12 <= smoothed(*ends) - exact <= 1e-12)


@given(segments)
def test_numpy_agrees_with_a_quadratic_programme(ends: tuple[Points, ...]) -> None:
    assert segment_distance(*ends) == pytest.approx(by_quadratic_programme(*ends), abs=1e-7)


@given(segments)
def test_expression_agrees_with_numpy(ends: tuple[Points, ...]) -> None:
    assert agrees(*ends)


@given(segments, st.floats(-2.0, 2.0), point)
def test_parallel_segments(ends: tuple[Points, ...], stretch: float, shift: Points) -> None:
    a0, a1 = ends[:2]
    b0, b1 = a0 + shift, a0 + shift + stretch * (a1 - a0)
    expected = by_quadratic_programme(a0, a1, b0, b1)
    assert segment_distance(a0, a1, b0, b1) == pytest.approx(expected, abs=1e-7)
    assert agrees(a0, a1, b0, b1)


@given(point, point, point)
def test_a_point_is_a_segment(place: Points, start: Points, end: Points) -> None:
    expected = by_quadratic_programme(place, place, start, end)
    assert segment_distance(place, place, start, end) == pytest.approx(expected, abs=1e-7)
    for order in ((place, place, start, end), (start, end, place, place)):
        assert agrees(*order)


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


# ---- nearly parallel --------------------------------------------------------------------------

LENGTH, APART = 0.09, 0.07
"""m; thighs of a small humanoid."""
angle = st.sampled_from([0.0, 1e-12, 1e-9, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 0.1])
sign = st.sampled_from([-1.0, 1.0])
nearly = st.builds(
    lambda tilt, twist, shift, first, second: (first * tilt, second * twist, shift),
    angle, angle, st.sampled_from([0.0, 1e-9, 0.02, LENGTH, 0.12]), sign, sign,
)  # fmt: skip


def thighs(tilt: float, twist: float, shift: float) -> tuple[Points, ...]:
    """Ends of two, side by side: tilted inwards, twisted [rad] and shifted along [m]."""
    way = LENGTH * np.array([np.sin(twist), np.sin(tilt), -np.cos(tilt) * np.cos(twist)])
    hip = np.array([0.0, APART, -shift])
    return np.zeros(3), np.array([0.0, 0.0, -LENGTH]), hip, hip + way


@given(nearly)
def test_nearly_parallel_thighs(case: tuple[float, float, float]) -> None:
    ends = thighs(*case)
    exact = float(segment_distance(*ends))
    assert exact == pytest.approx(by_quadratic_programme(*ends), abs=1e-9)
    assert -1e-6 < np.sqrt(smoothed(*ends)) - exact <= 1e-12
    assert np.all(np.isfinite(gradient(*ends)))
    second = np.array(HESSIAN(np.concatenate(ends)))
    # Without smoothing some are infinite: the nearest points jump from end to end.
    assert np.abs(second).max() < 2.0 * (1.0 + (APART / LENGTH) ** 2) / SOFTNESS


@given(nearly)
def test_the_gradient_leaves_no_kink(case: tuple[float, float, float]) -> None:
    """It is that of the value on both sides, and nearly the same a small step further."""
    place = np.concatenate(thighs(*case))
    direction = np.random.default_rng(0).normal(size=12)
    step = 1e-9
    before, after = (place + way * step * direction for way in (-1.0, 1.0))
    slope = (float(VALUE(after)) - float(VALUE(before))) / (2.0 * step)
    # Second derivatives may jump, so this step tells the first ones to their bound times it.
    assert slope == pytest.approx(float(gradient(*np.split(place, 4)) @ direction), abs=1e-3)
    change = gradient(*np.split(after, 4)) - gradient(*np.split(before, 4))
    assert np.abs(change).max() < 1e-3


DEGENERATE = {
    "one point twice": (0.0, 0.0, 0.0),
    "a point on a segment": (0.0, 0.0, 1.0),
    "one segment twice": (1.0, 0.0, 1.0),
    "end to end": (1.0, 1.0, 2.0),
}


@pytest.mark.parametrize("name", DEGENERATE)
def test_touching_segments_have_derivatives(name: str) -> None:
    along = np.array([0.0, 0.0, 0.1])
    end_a, start_b, end_b = (part * along for part in DEGENERATE[name])
    ends = (np.zeros(3), end_a, start_b, end_b)
    assert float(segment_distance(*ends)) == 0.0
    assert agrees(*ends)
    assert np.all(np.isfinite(gradient(*ends)))
    assert np.all(np.isfinite(np.array(HESSIAN(np.concatenate(ends)))))


@given(segments)
def test_expression_gradient_against_finite_differences(ends: tuple[Points, ...]) -> None:
    place, step = np.concatenate(ends), 1e-6
    direction = np.random.default_rng(0).normal(size=12)
    here = float(VALUE(place))
    ahead, behind = (float(VALUE(place + way * step * direction)) for way in (1, -1))
    slope = float(gradient(*ends) @ direction)
    # Within the smoothed width of a kink only the one-sided slopes bracket the gradient.
    sides = sorted([(ahead - here) / step, (here - behind) / step])
    assert sides[0] - 1e-4 <= slope <= sides[1] + 1e-4
