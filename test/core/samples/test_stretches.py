"""Marked samples as stretches of time."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.samples.stretches import (
    MOST_TIMES,
    lasting,
    list_stretches,
    stretches,
    unchanged,
    widened,
)

TIME = np.arange(0.0, 10.0, 0.1)


def marked(*spans: tuple[float, float]) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    mask = np.zeros(len(TIME), dtype=bool)
    for start, end in spans:
        mask |= (start - 0.01 < TIME) & (end + 0.01 > TIME)
    return mask


def test_stretches_have_a_first_and_a_last_time() -> None:
    found = stretches(marked((1.0, 2.0), (2.5, 2.5)), TIME)
    np.testing.assert_allclose(found, [(1.0, 2.0), (2.5, 2.5)])
    assert stretches(marked(), TIME) == ()


def test_near_stretches_are_one() -> None:
    mask = marked((1.0, 2.0), (2.5, 2.5), (4.0, 9.9))
    np.testing.assert_allclose(stretches(mask, TIME, 0.6), [(1.0, 2.5), (4.0, 9.9)])


@given(st.lists(st.booleans(), min_size=1, max_size=60))
def test_stretches_hold_what_was_marked_and_nothing_else(bits: list[bool]) -> None:
    mask, time = np.array(bits), np.arange(len(bits)) / 10.0
    again = np.zeros_like(mask)
    for start, end in stretches(mask, time):
        again |= (time >= start) & (time <= end)
    np.testing.assert_array_equal(again, mask)


def test_a_margin_on_both_sides() -> None:
    np.testing.assert_array_equal(widened(marked((3.0, 3.0)), TIME, 0.25), marked((2.8, 3.2)))
    np.testing.assert_array_equal(widened(marked((0.0, 0.1)), TIME, 0.2), marked((0.0, 0.3)))


def test_what_lasts() -> None:
    mask = marked((1.0, 1.3), (5.0, 6.0))
    np.testing.assert_array_equal(lasting(mask, TIME, 0.8), marked((5.0, 6.0)))


def test_times_for_a_person() -> None:
    assert list_stretches([]) == ""
    assert list_stretches([(1.23, 1.25)]) == "at 1.2 s"
    assert list_stretches([(7.0, 8.5), (1.2, 1.2)]) == "at 1.2 s, 7.0 to 8.5 s"
    many = [(float(k), k + 0.1 * k) for k in range(1, MOST_TIMES + 3)]
    assert list_stretches(many) == "at 3.0 to 3.3 s, 4.0 to 4.4 s, 5.0 to 5.5 s, 2 more times"


def test_parts_in_which_nothing_changes() -> None:
    parts = unchanged(np.array([0, 0, 1, 1, 1]), np.array([2, 2, 2, 3, 3]))
    assert [part.tolist() for part in parts] == [[0, 1], [2], [3, 4]]
