"""Acceleration as a shift of the zero-moment point."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import HEIGHT, SETTINGS, recording
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.quasi_static import too_fast, zmp_shift


def swaying(amplitude: float, pace: float, noise: float = 0.0) -> Aligned:
    """The CoM goes to and fro in x, `pace` in rad/s."""
    one = recording().aligned[1]
    com = one.states.com.copy()
    com[:, :, 0] = (amplitude * np.sin(pace * one.time))[:, None]
    com[:, :, 1] = 0.0
    com[..., :2] += noise * np.random.default_rng(5).standard_normal(com[..., :2].shape)
    return replace(one, states=replace(one.states, com=com))


@pytest.mark.parametrize("pace", [1.0, 2.0, 3.5])
def test_the_shift_is_height_times_acceleration_over_gravity(pace: float) -> None:
    one = swaying(0.02, pace)
    shift, _ = zmp_shift(one)
    expected = HEIGHT / GRAVITY * 0.02 * pace**2 * np.abs(np.sin(pace * one.time))
    np.testing.assert_allclose(shift[50:-50], expected[50:-50], atol=0.05 * expected.max())


def test_slow_motion_is_not_too_fast() -> None:
    for number, one in recording().aligned.items():
        assert not too_fast(one, SETTINGS).any(), number
    assert not too_fast(swaying(0.02, 1.0), SETTINGS).any()


def test_what_is_too_fast_is_marked_where_it_is() -> None:
    one = swaying(0.02, 4.0)
    slow = one.time < 15.0
    com = np.where(slow[:, None, None], one.states.com[0], one.states.com)
    mixed = replace(one, states=replace(one.states, com=com))
    marked = too_fast(mixed, SETTINGS)
    assert not marked[one.time < 14.7].any()
    fast = (
        HEIGHT / GRAVITY * 0.02 * 16.0 * np.abs(np.sin(4.0 * one.time)) > 1.2 * SETTINGS.cop_std_m
    )
    assert marked[(one.time > 15.3) & (one.time < 29.5) & fast].all()


def test_encoder_steps_alone_are_not_too_fast() -> None:
    assert not too_fast(swaying(0.02, 1.0, noise=0.002), SETTINGS).any()


def test_steps_of_coarse_encoders_on_a_tall_robot_are_no_haste() -> None:
    one = swaying(0.0, 1.0)
    levers, amplitudes = np.array([0.65, 0.4, 0.15]), np.array([0.03, 0.05, 0.04])
    angles = amplitudes * np.sin(0.5 * one.time[:, None] + np.arange(3))
    step = 2.0 * np.pi / 2**12
    com = one.states.com.copy()
    com[..., 0] = (step * np.rint(angles / step) @ levers)[:, None]
    com[..., 2] = 0.7
    tall = replace(one, states=replace(one.states, com=com))
    assert zmp_shift(tall)[0].max() > 1.5 * SETTINGS.cop_std_m
    assert not too_fast(tall, SETTINGS).any()


def test_a_gap_in_the_recording_is_no_haste() -> None:
    one = swaying(0.05, 0.5)
    kept = (one.time < 10.0) | (one.time > 16.0)
    assert not too_fast(one.part(kept), SETTINGS).any()
