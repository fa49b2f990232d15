"""A set's gap does not hang on how noisy its cells are."""

from __future__ import annotations

import math

import pytest

from blind.gap import MeasuredGap, floor_of


def test_noisy_sets_have_no_larger_gap() -> None:
    calm, usual, loud = (MeasuredGap(0.3, 0.02, 0.05 * k, 0.02 * k) for k in (0.5, 1.0, 2.0))
    floor = floor_of([calm, usual, loud])
    assert floor.with_noise[1] == pytest.approx(math.hypot(0.02, 0.02))
    assert [one.over(floor) for one in (calm, usual, loud)] == pytest.approx([1.0, 1.0, 1.0])
    assert MeasuredGap(0.3, 0.08, 0.0, 0.0).over(floor) == pytest.approx(
        math.hypot(0.08, 0.02) / math.hypot(0.02, 0.02)
    )
