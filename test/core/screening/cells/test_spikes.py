"""Electrical spikes are told from what hits the robot."""

from __future__ import annotations

import numpy as np
import pytest

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.spikes import Jumps, find_jumps
from shoecal_core.screening.noise import noise

SHOE = shoes.shoe("nao_shoe")
TIME = np.arange(2000) / 100.0
GAIN: FloatArray = np.asarray(12.0 * SHOE.polarity)


def readings(std: float = 0.001) -> FloatArray:
    rng = np.random.default_rng(3)
    slow = np.sin(0.4 * TIME[:, None] + np.arange(8.0))
    return np.asarray(slow + std * rng.standard_normal((len(TIME), 8)))


def found(values: FloatArray) -> Jumps:
    return find_jumps(SHOE, values, noise(values), GAIN, 0.3)


def test_a_quiet_recording_has_none() -> None:
    for std in (1e-5, 0.001, 0.02):
        jumps = found(readings(std))
        assert not jumps.spikes.any()
        assert not jumps.hits.any()


@pytest.mark.parametrize("length", [1, 2, 3])
@pytest.mark.parametrize("size", [0.1, -4.0])
def test_one_channel_that_jumps_alone(length: int, size: float) -> None:
    clean, values = readings(), readings()
    values[500 : 500 + length, 6] += size
    jumps = found(values)
    expected = np.zeros_like(jumps.spikes)
    expected[500 : 500 + length, 6] = True
    np.testing.assert_array_equal(jumps.spikes, expected)
    assert not jumps.hits.any()
    assert np.abs(jumps.calm - clean).max() < 0.02


def test_a_foot_that_is_hit_jumps_in_proportion() -> None:
    values = readings()
    values[700, :4] += np.array([1.2, 0.5, -0.1, -0.6]) / GAIN[:4]
    jumps = found(values)
    assert not jumps.spikes.any()
    assert np.flatnonzero(jumps.hits).tolist() == [700]


def test_in_noise_that_hides_companions_nothing_is_said_of_the_cable() -> None:
    values = readings(0.01)
    values[300, 2] += 0.1
    jumps = found(values)
    assert not jumps.spikes.any()
    assert jumps.hits[300]


def test_steps_are_no_jumps() -> None:
    values = readings()
    values[1000:, 3] += 1.0
    assert not found(values).spikes.any()
