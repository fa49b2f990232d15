"""Where the right foot stands."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.errors import ShoecalError
from shoecal_core.robot.double_support import DoubleSupport, count_distinct

numbers = st.floats(-1.0, 1.0)
supports = st.builds(DoubleSupport, numbers, numbers, st.floats(-math.pi, math.pi))


@given(supports, numbers, numbers)
def test_points_there_and_back(support: DoubleSupport, x: float, y: float) -> None:
    c, s = math.cos(support.dtheta), math.sin(support.dtheta)
    moved = support.right_to_left(np.array([x, y]))
    np.testing.assert_allclose(
        moved, [support.dx + c * x - s * y, support.dy + s * x + c * y], atol=1e-15
    )
    np.testing.assert_allclose(support.left_to_right(moved), [x, y], atol=1e-15)


def test_many_points_at_once() -> None:
    support = DoubleSupport(0.1, -0.2, 0.7)
    points = np.random.default_rng(0).normal(size=(2, 3, 2))
    moved = support.right_to_left(points)
    for index in np.ndindex(2, 3):
        np.testing.assert_allclose(moved[index], support.right_to_left(points[index]))
    np.testing.assert_allclose(support.left_to_right(moved), points, atol=1e-15)


def test_the_frame_of_the_right_foot() -> None:
    support = DoubleSupport(0.1, -0.2, math.pi / 2)
    np.testing.assert_array_equal(support.translation, [0.1, -0.2])
    # Turned to the left, the right foot's forward is the left foot's left.
    np.testing.assert_allclose(support.rotation @ [1.0, 0.0], [0.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(support.right_to_left(np.zeros(2)), [0.1, -0.2])


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", [0, 1, 2])
def test_what_is_not_finite_is_refused(bad: float, place: int) -> None:
    values = [0.0, -0.1, 0.2]
    values[place] = bad
    with pytest.raises(ShoecalError, match="finite"):
        DoubleSupport(*values)


@pytest.mark.parametrize("dtheta", [6.3, -7.0, 1.7e308])
def test_more_than_one_turn_is_refused(dtheta: float) -> None:
    with pytest.raises(ShoecalError, match="within one turn"):
        DoubleSupport(0.0, -0.1, dtheta)


def test_supports_that_nearly_coincide_are_one() -> None:
    """However they would be rounded."""
    near = [DoubleSupport(0.0049 + 0.0002 * step, -0.1, 0.3) for step in range(3)]
    assert count_distinct(near) == 1
    assert count_distinct([*near, DoubleSupport(0.0, -0.1, 0.3 - math.tau)]) == 1
    assert (
        count_distinct([*near, DoubleSupport(0.0, -0.1, 0.35), DoubleSupport(0.1, -0.1, 0.3)]) == 3
    )
    assert count_distinct([]) == 0


def test_in_words_it_has_units() -> None:
    assert (
        str(DoubleSupport(0.01, -0.112, 0.26)) == "dx 0.01 m, dy -0.112 m, dtheta 0.26 rad (15 deg)"
    )
