"""Pushes that the joints do not show."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import SETTINGS
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.loads.disturbed import disturbed

TIME = np.arange(3000) / 100.0


def calm(noise: float = 0.02) -> tuple[FloatArray, FloatArray]:
    """Force and place errors of a robot that nothing disturbs."""
    rng = np.random.default_rng(6)
    slow = 0.002 * np.stack((np.sin(0.5 * TIME), np.cos(0.4 * TIME)), axis=1)
    place = slow + 1e-3 * noise * rng.standard_normal((len(TIME), 2))
    return noise * rng.standard_normal(len(TIME)) + 0.2, place


def bump(start: float, end: float) -> FloatArray:
    return ((start <= TIME) & (end >= TIME)).astype(float)


@pytest.mark.parametrize("noise", [0.01, 0.3])
def test_noise_and_slow_errors_are_none(noise: float) -> None:
    assert not disturbed(TIME, *calm(noise), SETTINGS).any()


def test_force_that_is_not_the_weight() -> None:
    force, place = calm()
    marked = disturbed(TIME, force - 2.0 * bump(10.0, 14.0), place, SETTINGS)
    assert marked[bump(10.02, 13.98) > 0.0].all()
    assert not marked[bump(9.9, 14.1) == 0.0].any()


def test_a_cop_that_leaves_the_model_for_a_moment() -> None:
    force, place = calm()
    marked = disturbed(TIME, force, place + 0.006 * bump(5.0, 5.2)[:, None], SETTINGS)
    assert marked[bump(5.02, 5.18) > 0.0].all()
    assert not marked[bump(4.9, 5.3) == 0.0].any()


def test_a_cop_that_is_off_for_long_is_the_models_own() -> None:
    force, place = calm()
    marked = disturbed(TIME, force, place + 0.004 * bump(8.0, 20.0)[:, None], SETTINGS)
    assert marked.mean() < 0.1


def test_another_weight_all_along_is_told_elsewhere() -> None:
    force, place = calm()
    assert not disturbed(TIME, force + 5.0, place, SETTINGS).any()
