from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from shoecal_core.planning.timing import GRID, Profile, Rates, fastest

RATES = Rates(
    joint_speed=np.array([0.2, 0.2]),
    joint_acceleration=np.array([0.5, 0.5]),
    com_speed=0.014,
    com_acceleration=0.012,
    state_rate=1e3,
)


def straight(length: float, count: int = 60) -> tuple[CubicSpline, np.ndarray, np.ndarray]:
    """Joints that hardly move while the CoM goes straight ahead."""
    states = np.linspace(0.0, 1e-3, count + 1)[:, None] * np.ones(2)
    s = np.linspace(0.0, count, GRID * count + 1)
    com = np.column_stack([length * s / count, np.zeros_like(s)])
    return CubicSpline(np.arange(count + 1), states), com, s


@given(st.floats(0.03, 0.3))
@hypothesis_settings(max_examples=15)
def test_a_straight_way_takes_a_trapezoid(length: float) -> None:
    """From rest to rest over L with speed v and acceleration a: L / v + v / a."""
    path, com, s = straight(length)
    v, a = RATES.com_speed, RATES.com_acceleration * np.cos(np.pi / 16)
    duration = fastest(path, com, s, RATES).times[-1]
    assert duration == pytest.approx(length / v + v / a, rel=0.02)


def test_a_short_way_takes_a_triangle() -> None:
    path, com, s = straight(0.005)
    a = RATES.com_acceleration * np.cos(np.pi / 16)
    duration = fastest(path, com, s, RATES).times[-1]
    assert duration == pytest.approx(2.0 * np.sqrt(0.005 / a), rel=0.03)


@given(st.integers(0, 10_000))
@hypothesis_settings(max_examples=15)
def test_limits_hold_on_crooked_paths(seed: int) -> None:
    generator = np.random.default_rng(seed)
    # A horizon's cost makes transitions change gradually.
    steps = np.cumsum(generator.normal(size=(40, 2)), axis=0) * 0.004
    path = CubicSpline(np.arange(41), np.vstack([np.zeros(2), np.cumsum(steps, axis=0)]))
    s = np.linspace(0.0, 40.0, 40 * GRID + 1)
    profile = fastest(path, 0.2 * path(s), s, RATES)
    time = np.arange(0.0, profile.times[-1], 0.02)
    place, rate = profile.at(time)
    joints = path(place)
    speed = np.abs(path(place, 1) * rate[:, None])
    assert np.all(speed <= RATES.joint_speed * 1.05)
    ground = 0.2 * joints
    acceleration = np.diff(ground, 2, axis=0) / 0.02**2
    assert np.linalg.norm(acceleration, axis=1).max() <= RATES.com_acceleration * 1.1
    assert np.linalg.norm(np.diff(ground, axis=0), axis=1).max() / 0.02 <= RATES.com_speed * 1.03


def test_place_and_rate_agree() -> None:
    path, com, s = straight(0.1)
    profile = fastest(path, com, s, RATES)
    time = np.linspace(0.0, profile.times[-1], 4001)
    place, rate = profile.at(time)
    np.testing.assert_allclose(np.gradient(place, time)[1:-1], rate[1:-1], atol=0.05 * rate.max())
    assert place[0] == 0.0
    assert rate[0] == 0.0
    assert place[-1] == pytest.approx(s[-1])
    assert rate[-1] == pytest.approx(0.0, abs=1e-9)
    before, after = profile.at(np.array([-1.0, profile.times[-1] + 1.0]))[0]
    assert before == 0.0
    assert after == pytest.approx(s[-1])


def test_constant_acceleration_by_hand() -> None:
    """Half a unit at 1/s^2, then back to rest: one second each."""
    profile = Profile(np.array([0.0, 0.5, 1.0]), np.array([0.0, 1.0, 0.0]))
    np.testing.assert_allclose(profile.times, [0.0, 1.0, 2.0])
    place, rate = profile.at(np.array([0.5, 1.5]))
    np.testing.assert_allclose(place, [0.125, 0.875])
    np.testing.assert_allclose(rate, [0.5, 0.5])
