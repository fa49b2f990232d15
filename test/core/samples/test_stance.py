"""Samples of one stance: frames, rates and shapes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.estimation import synthetic
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.samples.stance import Stance, make_stance
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, combined, foot_wrenches, weight_below

SUPPORT = synthetic.SUPPORTS[1]


@pytest.fixture
def stance(shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator) -> Stance:
    return synthetic.stance(shoe, truth, SUPPORT, rng)


def test_columns_and_base_are_the_total_wrench(
    shoe: Shoe, truth: ChannelParameters, stance: Stance
) -> None:
    outputs = truth.outputs(stance.readings)
    total = combined(foot_wrenches(shoe, outputs), SUPPORT)
    np.testing.assert_allclose(outputs @ stance.columns + stance.base, total, atol=1e-10)
    np.testing.assert_allclose(stance.reference, total, atol=1e-10)
    assert stance.hanging is None


@pytest.mark.parametrize("foot", [0, 1])
def test_in_single_support_only_the_standing_foot_counts(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator, foot: int
) -> None:
    stance = synthetic.single_stance(shoe, truth, foot, rng)
    assert stance.hanging == 1 - foot
    outputs = truth.outputs(stance.readings)
    np.testing.assert_allclose(
        outputs @ stance.columns + stance.base, foot_wrenches(shoe, outputs)[:, foot], atol=1e-10
    )
    np.testing.assert_array_equal(stance.base, weight_below(shoe)[foot])
    np.testing.assert_allclose(foot_wrenches(shoe, outputs)[:, 1 - foot], 0.0, atol=1e-10)


def test_rate_duration_and_parts(shoe: Shoe) -> None:
    time = np.linspace(3.0, 5.0, 101)
    place = np.stack((0.05 * time, -0.02 * time), axis=1)
    stance = make_stance(
        4, shoe, SUPPORT, (True, True), time,
        np.zeros((101, len(shoe.channels))), np.full(101, 50.0), place,
    )  # fmt: skip
    np.testing.assert_allclose(stance.cop_rate, np.tile([0.05, -0.02], (101, 1)), atol=1e-12)
    assert stance.duration == pytest.approx(2.02)
    part = stance.part(slice(10, 30))
    assert len(part.time) == 20
    assert part.run == 4
    np.testing.assert_array_equal(part.cop, stance.cop[10:30])
    np.testing.assert_array_equal(part.columns, stance.columns)
    assert stance.part(slice(5, 6)).duration == 0.0


def test_one_sample_has_no_rate(shoe: Shoe) -> None:
    stance = make_stance(
        1, shoe, SUPPORT, (True, True), np.zeros(1),
        np.zeros((1, len(shoe.channels))), np.full(1, 50.0), np.zeros((1, 2)),
    )  # fmt: skip
    np.testing.assert_array_equal(stance.cop_rate, np.zeros((1, 2)))


@pytest.mark.parametrize("name", ["readings", "force", "cop", "cop_rate", "columns", "base"])
def test_other_shapes_and_numbers_are_refused(stance: Stance, name: str) -> None:
    array = getattr(stance, name)
    wider = np.concatenate((array, array[..., :1]), axis=-1)
    with pytest.raises(ShapeError, match=name):
        replace(stance, **{name: wider})  # type: ignore[arg-type]
    spoilt = array.copy()
    spoilt.flat[0] = np.nan
    with pytest.raises(ShoecalError, match=f"run 1: {name} holds a number that is not finite"):
        replace(stance, **{name: spoilt})
