from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.simulation.effects.chains import NAO, item, on_first, shoes_with, through
from shoecal_core.arrays import FloatArray

CELL = "left/front_left"


def cycles(middle: float, span: float, count: int = 3) -> FloatArray:
    """Up and down `count` times between the ends of a range, from no load [N]."""
    up = np.linspace(middle - span / 2.0, middle + span / 2.0, 101)
    return np.concatenate([[0.0, up[0]], *[np.concatenate((up, up[::-1]))] * count])


def last_loop(reached: FloatArray) -> tuple[FloatArray, FloatArray]:
    """(101,) the way up and the way down, both in the order of force [N]."""
    return reached[-202:-101], reached[-101:][::-1]


@settings(max_examples=25)
@given(
    st.floats(3.0, 15.0), st.floats(2.0, 20.0), st.floats(0.01, 0.1), st.sampled_from((1.0, -1.0))
)
def test_a_loop_is_as_wide_as_stated_over_whatever_range(
    middle: float, span: float, fraction: float, sign: float
) -> None:
    """Readings lag, or lead."""
    shoes = shoes_with(item("hysteresis", CELL, fraction=sign * fraction))
    up, down = last_loop(through(shoes, on_first(NAO, cycles(middle, span)))[:, 0])
    wide = sign * (down - up)
    assert (wide >= -1e-9).all()
    assert np.max(wide) == pytest.approx(fraction * span, rel=0.1)
    assert np.argmax(wide) == pytest.approx(50, abs=15)


def test_hysteresis_leaves_the_mean_slope_over_a_third_of_the_full_scale() -> None:
    shoes = shoes_with(item("hysteresis", CELL, fraction=0.05))
    up, _ = last_loop(through(shoes, on_first(NAO, cycles(10.0, 20.0)))[:, 0])
    assert up[-1] - up[0] == pytest.approx(20.0, rel=2e-3)


def test_hysteresis_knows_no_time_and_begins_anew_on_a_foot_lifted() -> None:
    shoes = shoes_with(item("hysteresis", "left", fraction=0.05))
    forces = np.tile(cycles(8.0, 10.0)[:, None], 8)
    fast, slow = (through(shoes, forces, period=period) for period in (0.01, 10.0))
    assert (fast == slow).all()
    assert (fast[:, 4:] == forces[:, 4:]).all()
    assert (np.abs(fast[50, :4] - forces[50, :4]) > 0.02).all()


def test_a_small_loop_within_a_large_one_closes() -> None:
    """Return-point memory, the mark of a Preisach model."""
    shoes = shoes_with(item("hysteresis", CELL, fraction=0.05))
    force = np.concatenate([np.linspace(a, b, 50) for a, b in ((0, 10), (10, 6), (6, 10))])
    reached = through(shoes, on_first(NAO, force))[:, 0]
    assert reached[-1] == pytest.approx(reached[49], abs=1e-9)


@settings(max_examples=20)
@given(st.floats(-0.1, 0.1), st.floats(2.0, 60.0))
def test_a_step_creeps_by_its_fraction_with_its_time(fraction: float, time: float) -> None:
    shoes = shoes_with(item("creep", CELL, fraction=fraction, time_s=time))
    period = time / 50.0
    felt = on_first(NAO, np.concatenate(([0.0], np.full(2500, 10.0))))
    grown = through(shoes, felt, period=period)[1:, 0] - 10.0
    # The step itself takes one period.
    assert grown[50] == pytest.approx(10.0 * fraction * (1.0 - np.exp(-1.0)), rel=0.03, abs=1e-9)
    assert grown[-1] == pytest.approx(10.0 * fraction, rel=0.01, abs=1e-9)
    assert (np.diff(grown) * np.sign(fraction) >= -1e-12).all()


def test_creep_is_faster_at_first_and_slower_at_last_than_one_exponential() -> None:
    shoes = shoes_with(item("creep", CELL, fraction=0.1, time_s=10.0))
    felt = on_first(NAO, np.concatenate(([0.0], np.full(4000, 10.0))))
    grown = through(shoes, felt)[1:, 0] - 10.0
    assert grown[200] > 1.1 * (1.0 - np.exp(-0.2))
    assert grown[3000] < 0.99 * (1.0 - np.exp(-3.0))


def test_creep_falls_back_after_the_load() -> None:
    shoes = shoes_with(item("creep", CELL, fraction=0.1, time_s=1.0))
    felt = on_first(NAO, np.concatenate((np.full(2000, 10.0), np.zeros(2000))))
    reached = through(shoes, felt)[:, 0]
    assert reached[2001] == pytest.approx(1.0, rel=0.03)
    assert reached[-1] == pytest.approx(0.0, abs=0.01)
