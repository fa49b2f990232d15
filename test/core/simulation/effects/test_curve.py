from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.simulation.effects.chains import NAO, item, on_first, shoes_with, through

CELL = "left/front_left"


@settings(max_examples=25)
@given(st.floats(-0.01, 0.01), st.floats(-5e-4, 5e-4))
def test_small_forces_bend_by_the_stated_coefficients(quadratic: float, cubic: float) -> None:
    shoes = shoes_with(item("nonlinearity", CELL, quadratic_per_n=quadratic, cubic_per_n2=cubic))
    force = np.linspace(-2.0, 2.0, 41)
    added = through(shoes, on_first(NAO, force))[:, 0] - force
    expected = quadratic * force**2 + cubic * force**3
    assert added == pytest.approx(expected, rel=1e-3, abs=1e-6)


def test_large_forces_bend_by_almost_as_much_but_by_another_law() -> None:
    force = np.array([20.0])
    quadratic, cubic = (
        through(shoes_with(item("nonlinearity", CELL, **{key: size})), on_first(NAO, force))[0, 0]
        - force[0]
        for key, size in (("quadratic_per_n", 0.005), ("cubic_per_n2", 1e-4))
    )
    assert 0.95 < quadratic / (0.005 * 400.0) < 0.98
    assert 0.96 < cubic / (1e-4 * 8000.0) < 0.99


@settings(max_examples=25)
@given(st.floats(1.0, 40.0))
def test_a_saturated_cell_ends_at_its_level_with_a_smooth_knee(level: float) -> None:
    force = np.linspace(-level, 3.0 * level, 401)
    felt = through(shoes_with(item("saturation", CELL, level_n=level)), on_first(NAO, force))[:, 0]
    assert (np.diff(felt) >= 0.0).all()
    assert (felt <= level + 1e-9).all()
    assert felt == pytest.approx(np.minimum(force, level), abs=0.015 * level)
    far = np.abs(force - level) > 0.2 * level
    assert felt[far] == pytest.approx(np.minimum(force, level)[far], abs=1e-5 * level)


def test_other_cells_stay() -> None:
    shoes = shoes_with(
        item("saturation", CELL, level_n=2.0), item("nonlinearity", CELL, quadratic_per_n=0.01)
    )
    forces = np.full((3, 8), 5.0)
    assert (through(shoes, forces)[:, 1:] == forces[:, 1:]).all()
