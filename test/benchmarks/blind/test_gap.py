"""A set's gap does not hang on how noisy its cells are."""

from __future__ import annotations

import math

import numpy as np
import pytest

from blind.gap import AddedNoise, MeasuredGap, floor_of
from population import nao
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.stance import make_stance


def test_noisy_sets_have_no_larger_gap() -> None:
    calm, usual, loud = (MeasuredGap(0.3, 0.02, 0.05 * k, 0.02 * k) for k in (0.5, 1.0, 2.0))
    floor = floor_of([calm, usual, loud])
    assert floor.with_noise[1] == pytest.approx(math.hypot(0.02, 0.02))
    assert [one.over(floor) for one in (calm, usual, loud)] == pytest.approx([1.0, 1.0, 1.0])
    assert MeasuredGap(0.3, 0.08, 0.0, 0.0).over(floor) == pytest.approx(
        math.hypot(0.08, 0.02) / math.hypot(0.02, 0.02)
    )


def test_noise_that_was_added_is_taken_off_again() -> None:
    rng, shoe = np.random.default_rng(2), nao()[1]
    time = np.arange(0.0, 2.0, 0.01)
    readings, added = rng.standard_normal((2, len(time), len(shoe.names)))
    support = DoubleSupport(0.0, -0.1, 0.0)
    stance = make_stance(
        3, shoe, support, (True, True), time[20:150], (readings + added)[20:150],
        np.full(130, 50.0), np.zeros((130, 2)),
    )  # fmt: skip
    noise = AddedNoise({3: time}, {3: added}, MeasuredGap(0.0, 0.0))
    np.testing.assert_allclose(noise.taken_off(stance).readings, readings[20:150])
