from __future__ import annotations

import numpy as np
import pytest

from shoecal_ros.inputs.stillness import Stillness

STEP_NS = 10_000_000


def fed(still: Stillness, speed: float, samples: int, start: int = 0) -> Stillness:
    for index in range(start, start + samples):
        angle = speed * index * STEP_NS / 1e9
        still.add(index * STEP_NS, np.array([0.3, angle, np.nan]))
    return still


def test_it_takes_its_time() -> None:
    still = Stillness(0.01, 0.5, 0.0)
    assert not still.still
    fed(still, 0.0, 50)
    assert not still.still
    fed(still, 0.0, 1, start=50)
    assert still.still


@pytest.mark.parametrize(("speed", "expected"), [(0.009, True), (0.011, False), (-0.011, False)])
def test_the_limit_of_speed(speed: float, expected: bool) -> None:
    assert fed(Stillness(0.01, 0.5, 0.0), speed, 200).still is expected


def test_steps_of_an_encoder_are_no_motion() -> None:
    still = Stillness(1e-4, 0.5, 0.002)
    for index in range(100):
        still.add(index * STEP_NS, np.array([0.0015 * (index % 2)]))
    assert still.still


def test_moving_and_standing_again() -> None:
    still = fed(Stillness(0.01, 0.5, 0.0), 0.0, 100)
    still.add(100 * STEP_NS, np.array([0.3, 0.5, np.nan]))
    assert not still.still
    for index in range(101, 200):
        still.add(index * STEP_NS, np.array([0.3, 0.5, np.nan]))
    assert still.still


def test_time_that_turns_back_begins_anew() -> None:
    still = fed(Stillness(0.01, 0.5, 0.0), 0.0, 100)
    still.add(0, np.array([0.3, 0.0, np.nan]))
    assert not still.still


def test_a_robot_that_was_told_to_move() -> None:
    still = fed(Stillness(0.01, 0.5, 0.0), 0.0, 100)
    still.restart()
    assert not still.still


def test_angles_that_nobody_knows_are_not_still() -> None:
    still = Stillness(0.01, 0.5, 0.0)
    for index in range(100):
        still.add(index * STEP_NS, np.array([np.nan]))
    assert not still.still


def test_stamps_that_creep_fill_no_memory() -> None:
    still = Stillness(0.01, 0.5, 0.004)
    for index in range(20_000):
        still.add(index + 1, np.zeros(3))
    assert len(still._samples) == 1
    assert not still.still
    fast = Stillness(0.01, 0.5, 0.004)
    for index in range(20_000):
        fast.add(index * 50_000, np.zeros(3))
    assert len(fast._samples) <= 2001
    assert fast.still
