"""Residuals and their derivatives (paper, eq. 18)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from core.estimation import synthetic
from core.estimation.derivatives import assert_jacobian
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.residuals import (
    ResidualWeights,
    hanging_residuals,
    pack,
    residuals,
    rows_of,
    unpack,
)
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.stance import Stance, make_stance
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, columns_in_left, cop

WEIGHTS = ResidualWeights(force=0.3, cop=0.0025, correlation=2.0)
SUPPORT = synthetic.SUPPORTS[1]


def away(truth: ChannelParameters, rng: np.random.Generator) -> FloatArray:
    """A parameter vector some way off the truth."""
    count = len(truth.gain)
    return pack(
        ChannelParameters(
            truth.gain * rng.uniform(0.85, 1.15, count), truth.offset + rng.normal(size=count)
        ),
        0.013,
    )


def walk(shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator) -> list[Stance]:
    """Two double supports and one single support on each foot."""
    return [
        *synthetic.stances(shoe, truth, rng, synthetic.SUPPORTS[:2], count=60),
        synthetic.single_stance(shoe, truth, 0, rng, run=3, count=61, swing=0.4),
        synthetic.single_stance(shoe, truth, 1, rng, run=4, count=59, swing=0.4),
    ]


def first(
    function: Callable[..., tuple[FloatArray, FloatArray]], *others: object
) -> Callable[[FloatArray], FloatArray]:
    """The residuals of a function of a vector and others that returns derivatives too."""
    return lambda vector: function(vector, *others)[0]


def test_the_vector_has_one_order(truth: ChannelParameters) -> None:
    vector = pack(truth, 0.02)
    count = len(truth.gain)
    np.testing.assert_array_equal(vector[:count], truth.gain)
    np.testing.assert_array_equal(vector[count : 2 * count], truth.offset)
    parameters, late = unpack(vector)
    np.testing.assert_array_equal(parameters.gain, truth.gain)
    np.testing.assert_array_equal(parameters.offset, truth.offset)
    assert late == vector[-1] == 0.02


def test_no_residual_at_the_truth(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    for stance in walk(shoe, truth, rng):
        error, _ = residuals(pack(truth, 0.0), stance, WEIGHTS)
        np.testing.assert_allclose(error, 0.0, atol=1e-9)
        if stance.hanging is not None:
            error, _ = hanging_residuals(pack(truth, 0.0), stance, shoe, WEIGHTS, 50.0)
            np.testing.assert_allclose(error, 0.0, atol=1e-9)
    errors, _ = rows_of(walk(shoe, truth, rng), shoe, WEIGHTS)(pack(truth, 0.0))
    np.testing.assert_allclose(errors, 0.0, atol=1e-6)


def test_residuals_by_hand() -> None:
    """Two feet, all forces one newton but one: GRF 9 N for 10 N, CoP from the weighted mean."""
    square = [(0.1, 0.05), (0.1, -0.05), (-0.1, 0.05), (-0.1, -0.05)]
    shoe = shoes.made(shoes.cells(0, square) + shoes.cells(1, square))
    readings = np.array([[2.0, 1, 1, 1, 1, 1, 1, 1]])
    stance = make_stance(
        1, shoe, DoubleSupport(0.0, -0.2, 0.0), (True, True), np.zeros(1), readings,
        np.array([10.0]), np.array([[0.01, 0.02]]),
    )  # fmt: skip
    stance = replace(stance, cop_rate=np.array([[0.5, -0.25]]))
    vector = pack(ChannelParameters(np.ones(8), np.zeros(8)), 0.1)
    error, _ = residuals(vector, stance, ResidualWeights(force=0.5, cop=0.01, correlation=1.0))
    x = 0.1 / 9.0
    y = (5 * 0.0 + 0.05 - 4 * 0.2) / 9.0
    np.testing.assert_allclose(
        error,
        [(9.0 - 10.0) / 0.5, (x - 0.01 - 0.1 * 0.5) / 0.01, (y - 0.02 + 0.1 * 0.25) / 0.01],
        atol=1e-12,
    )


def test_residuals_are_those_of_the_measuring_side(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    """A second way to the same GRF and CoP."""
    stance = synthetic.stance(shoe, truth, SUPPORT, rng)
    vector = away(truth, rng)
    parameters, late = unpack(vector)
    measured = Sensing(shoe, parameters, minimum_force=-np.inf).measure(stance.readings)
    error, _ = residuals(vector, stance, WEIGHTS)
    force, place = error[: len(stance.time)], error[len(stance.time) :].reshape(2, -1).T
    np.testing.assert_allclose(force * WEIGHTS.force, measured.total_grf - stance.force)
    np.testing.assert_allclose(
        place * WEIGHTS.cop,
        measured.combined_cop(SUPPORT) - stance.cop - late * stance.cop_rate,
        atol=1e-12,
    )


def test_jacobian_of_loaded_feet(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    vector = away(truth, rng)
    for stance in walk(shoe, truth, rng):
        assert_jacobian(
            first(residuals, stance, WEIGHTS),
            residuals(vector, stance, WEIGHTS)[1],
            vector,
        )


def test_jacobian_of_a_hanging_foot(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    vector = away(truth, rng)
    for stance in walk(shoe, truth, rng)[2:]:
        assert_jacobian(
            first(hanging_residuals, stance, shoe, WEIGHTS, 50.0),
            hanging_residuals(vector, stance, shoe, WEIGHTS, 50.0)[1],
            vector,
        )


def test_jacobian_of_six_axis_sensors(rng: np.random.Generator) -> None:
    origin = [0.01, 0.0, 0.1]
    shoe = shoes.made(shoes.six_axis(0, origin) + shoes.six_axis(1, origin))
    outputs = rng.normal(size=(30, 10))
    outputs[:, [2, 7]] += 25.0
    wrench = outputs @ columns_in_left(shoe, SUPPORT)
    stance = make_stance(
        1, shoe, SUPPORT, (True, True), np.arange(30) / 20.0, outputs, wrench[:, 0],
        cop(wrench, 0.0),
    )  # fmt: skip
    vector = pack(ChannelParameters(np.full(10, 1.1), np.full(10, 0.3)), -0.01)
    assert_jacobian(
        lambda v: residuals(v, stance, WEIGHTS)[0], residuals(vector, stance, WEIGHTS)[1], vector
    )


def test_all_rows_are_those_of_the_stances_by_their_weights(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    stances = walk(shoe, truth, rng)
    vector = away(truth, rng)

    def weighed(v: FloatArray) -> tuple[FloatArray, FloatArray]:
        errors, jacobians = [], []
        for stance in stances:
            share = np.sqrt(WEIGHTS.of_sample(stance))
            parts = [residuals(v, stance, WEIGHTS)]
            if stance.hanging is not None:
                mean = float(stance.force.mean())
                parts.append(hanging_residuals(v, stance, shoe, WEIGHTS, mean))
            errors += [share * part[0] for part in parts]
            jacobians += [share * part[1] for part in parts]
        return np.concatenate(errors), np.concatenate(jacobians)

    rows = rows_of(stances, shoe, WEIGHTS)
    for found, expected in zip(rows(vector), weighed(vector), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12)
    assert_jacobian(lambda v: rows(v)[0], rows(vector)[1], vector, tolerance=1e-6)


def test_an_offset_pattern_that_nobody_can_see(rng: np.random.Generator) -> None:
    """Plus, minus, minus, plus under a rectangle: no force and no moment."""
    shoe = shoes.shoe("nao_shoe")
    truth = synthetic.truth(shoe, rng)
    stances = walk(shoe, truth, rng)
    vector = away(truth, rng)
    for foot in (0, 1):
        moved = vector.copy()
        moved[8 + shoe.of_foot(foot)] += np.array([3.0, -3.0, -3.0, 3.0])
        for stance in stances:
            np.testing.assert_allclose(
                residuals(moved, stance, WEIGHTS)[0],
                residuals(vector, stance, WEIGHTS)[0],
                atol=1e-9,
            )
    jacobian = rows_of(stances, shoe, WEIGHTS)(vector)[1]
    pattern = np.zeros(17)
    pattern[8:12] = 1.0, -1.0, -1.0, 1.0
    np.testing.assert_allclose(jacobian @ pattern, 0.0, atol=1e-9)


# ---- weights ----------------------------------------------------------------------------------


def test_samples_count_by_the_time_they_stand_for(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    stance = synthetic.stance(shoe, truth, SUPPORT, rng, count=400)
    assert WEIGHTS.of_sample(stance) == pytest.approx(0.05 / 2.0)
    assert replace(WEIGHTS, correlation=0.05).of_sample(stance) == pytest.approx(1.0)
    assert replace(WEIGHTS, correlation=0.001).of_sample(stance) == 1.0
    assert WEIGHTS.of_sample(stance.part(slice(0, 0))) == 0.0


def test_twice_the_rate_is_not_twice_the_evidence(shoe: Shoe, truth: ChannelParameters) -> None:
    vector = away(truth, np.random.default_rng(1))

    def at(rate: float) -> tuple[float, FloatArray]:
        draw = np.random.default_rng(3)
        run = synthetic.stance(shoe, truth, SUPPORT, draw, count=round(20 * rate), rate=rate)
        errors, jacobian = rows_of([run], shoe, WEIGHTS)(vector)
        return float(errors @ errors), jacobian.T @ jacobian

    (slow_cost, slow), (fast_cost, fast) = at(20.0), at(100.0)
    assert fast_cost == pytest.approx(slow_cost, rel=2e-3)
    size = np.sqrt(np.diag(slow))
    np.testing.assert_allclose(fast / np.outer(size, size), slow / np.outer(size, size), atol=5e-3)


def test_a_hanging_moment_counts_as_the_cop_error_it_would_cause(
    shoe: Shoe, truth: ChannelParameters, rng: np.random.Generator
) -> None:
    stance = synthetic.single_stance(shoe, truth, 0, rng, weight=54.0)
    offset = truth.offset.copy()
    own = shoe.of_foot(1)
    # One newton too much at one cell of the hanging foot.
    offset[own[0]] += 1.0
    error, _ = hanging_residuals(
        pack(ChannelParameters(truth.gain, offset), 0.0), stance, shoe, WEIGHTS, 54.0
    )
    seen = error.reshape(3, -1)[:, 0]
    _, mx, my = at_cop(np.asarray(1.0), shoe.positions[own[0]])
    np.testing.assert_allclose(
        seen, [1.0 / 0.3, mx / (54.0 * 0.0025), my / (54.0 * 0.0025)], atol=1e-9
    )
