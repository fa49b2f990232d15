from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.arrays import FloatArray
from shoecal_ros.inputs.own_noise import ENDED_FRAMES, OwnNoise

BATCH = 5


def counted(noise: float, level: FloatArray, seed: int = 0) -> FloatArray:
    """(T,) a level [counts] with white noise, as a converter tells it."""
    return np.rint(level + noise * np.random.default_rng(seed).standard_normal(len(level)))


def fed(own: OwnNoise, readings: FloatArray, rate: float = 100.0) -> list[bool]:
    """Whether noise has ended, batch by batch."""
    found = []
    steps = np.diff(readings, axis=0).reshape(len(readings) - 1, -1)
    for first in range(0, len(steps) - BATCH + 1, BATCH):
        own.take(steps[first : first + BATCH], BATCH / rate)
        found.append(bool(own.ended.any()))
    return found


@pytest.mark.parametrize("noise", [0.9, 3.0, 1000.0])
def test_noise_that_cannot_rest_is_known_and_missed(noise: float) -> None:
    own = OwnNoise(1)
    readings = counted(noise, np.full(3000, 0.3))
    assert not any(fed(own, readings))
    assert own.noisy.all()
    ended = fed(own, np.full(101, readings[-1]))
    assert ended.index(True) <= ENDED_FRAMES // BATCH
    assert all(ended[ended.index(True) :])


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.2, 0.3, 0.4, 0.5])
@pytest.mark.parametrize("level", [0.0, 0.25, 0.5])
def test_a_converter_with_little_noise_may_rest_wherever_it_was_before(
    noise: float, level: float
) -> None:
    for seed in range(20):
        own = OwnNoise(1)
        fed(own, counted(noise, np.full(3000, level), seed))
        assert not any(fed(own, np.zeros(200)))


@pytest.mark.parametrize("speed", [0.01, 0.1, 0.3, 1.0, 30.0])
@pytest.mark.parametrize("noise", [0.0, 0.2, 0.4])
def test_a_robot_that_moved_may_stand_still(speed: float, noise: float) -> None:
    """Cells that sway at up to `speed` counts a reading, on coarse converters and fine ones."""
    swing = 2.0 * np.pi / 100.0
    own = OwnNoise(1)
    level = speed / swing * np.sin(swing * np.arange(4000))
    fed(own, counted(noise, level))
    assert not any(fed(own, np.zeros(300)))


def test_who_changes_again_must_be_known_anew() -> None:
    own = OwnNoise(1)
    fed(own, counted(2.0, np.zeros(2001)))
    assert any(fed(own, np.zeros(101)))
    fed(own, counted(2.0, np.zeros(101), seed=1))
    assert not own.noisy.any()
    assert not any(fed(own, np.zeros(101)))


def test_channels_are_each_judged_by_themselves() -> None:
    own = OwnNoise(2)
    noisy, calm = counted(2.0, np.zeros(2001)), counted(0.1, np.zeros(2001), seed=1)
    fed(own, np.stack([noisy, calm], axis=1))
    assert own.noisy.tolist() == [True, False]
    fed(own, np.zeros((101, 2)))
    assert own.ended.tolist() == [True, False]
