"""Uncertainty of GRF and CoP, against finite differences and against repeated draws."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.expected_error import expected_error
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

SUPPORT = DoubleSupport(0.03, -0.12, 0.3)


def case(
    name: str, seed: int, cases: int = 3
) -> tuple[Shoe, ChannelParameters, FloatArray, FloatArray]:
    """Shoe, parameters, readings (p, n) of loaded feet, and a covariance (2n, 2n)."""
    shoe, generator = shoes.shoe(name), np.random.default_rng(seed)
    count = len(shoe.channels)
    parameters = ChannelParameters(
        generator.choice([-1.0, 1.0], count) * generator.uniform(5.0, 15.0, count),
        generator.normal(0.0, 3.0, count),
    )
    outputs = generator.uniform(3.0, 9.0, (cases, count))
    root = 1e-4 * generator.normal(size=(2 * count, 2 * count))
    return shoe, parameters, (outputs - parameters.offset) / parameters.gain, root @ root.T


def measured(
    shoe: Shoe, vector: FloatArray, readings: FloatArray, support: DoubleSupport
) -> FloatArray:
    """(p, 9) GRF of both, left, right, then CoP of both, left, right."""
    gain, offset = np.split(vector, 2)
    got = Sensing(shoe, ChannelParameters(gain, offset)).measure(readings)
    return np.concatenate(
        [
            got.total_grf[:, None],
            got.grf,
            got.combined_cop(support),
            got.cop.reshape(len(readings), 4),
        ],
        axis=1,
    )


@pytest.mark.parametrize("name", shoes.NAMES)
@given(seed=st.integers(0, 1000))
def test_slopes_are_those_of_measuring(name: str, seed: int) -> None:
    shoe, parameters, readings, covariance = case(name, seed)
    vector = np.concatenate((parameters.gain, parameters.offset))
    jacobian = np.stack(
        [
            (
                measured(shoe, vector + step, readings, SUPPORT)
                - measured(shoe, vector - step, readings, SUPPORT)
            )
            / 2e-4
            for step in 1e-4 * np.eye(len(vector))
        ],
        axis=2,
    )
    variance = np.einsum("pai,ij,paj->pa", jacobian, covariance, jacobian)
    got = expected_error(shoe, SUPPORT, parameters.outputs(readings), readings, covariance)
    np.testing.assert_allclose(got.grf, np.sqrt(variance[:, 0]), rtol=1e-6)
    np.testing.assert_allclose(got.foot_grf, np.sqrt(variance[:, 1:3]), rtol=1e-6)
    np.testing.assert_allclose(got.cop, np.sqrt(variance[:, 3:5].sum(axis=1)), rtol=1e-5)
    feet = variance[:, 5:].reshape(-1, 2, 2).sum(axis=2)
    np.testing.assert_allclose(got.foot_cop, np.sqrt(feet), rtol=1e-5)


def test_repeated_draws_scatter_as_foretold(shoe: Shoe) -> None:
    name = shoe.name
    shoe, parameters, readings, covariance = case(name, 0, cases=1)
    vector = np.concatenate((parameters.gain, parameters.offset))
    generator = np.random.default_rng(1)
    drawn = [
        measured(shoe, generator.multivariate_normal(vector, covariance), readings, SUPPORT)[0]
        for _ in range(4000)
    ]
    spread = np.std(drawn, axis=0)
    got = expected_error(shoe, SUPPORT, parameters.outputs(readings), readings, covariance)
    assert got.grf[0] == pytest.approx(spread[0], rel=0.05)
    assert got.cop[0] == pytest.approx(np.hypot(*spread[3:5]), rel=0.05)
    np.testing.assert_allclose(got.foot_grf[0], spread[1:3], rtol=0.05)


def test_relative_gains_are_gains_in_other_units(shoe: Shoe) -> None:
    name = shoe.name
    shoe, parameters, readings, covariance = case(name, 2)
    outputs = parameters.outputs(readings)
    scale = np.concatenate((parameters.gain, np.ones_like(parameters.gain)))
    relative = covariance / np.outer(scale, scale)
    one = expected_error(shoe, SUPPORT, outputs, readings, covariance)
    other = expected_error(shoe, SUPPORT, outputs, outputs - parameters.offset, relative)
    for field in dataclasses.fields(one):
        np.testing.assert_allclose(getattr(one, field.name), getattr(other, field.name))


def test_a_foot_without_load_has_no_cop() -> None:
    shoe, _, readings, covariance = case("nao_shoe", 3)
    outputs = np.where(shoe.foot == 0, 6.0, 0.0) * np.ones_like(readings)
    got = expected_error(shoe, None, outputs, readings, covariance)
    assert np.isfinite(got.foot_cop[:, 0]).all()
    assert np.isnan(got.foot_cop[:, 1]).all()
    assert np.isnan(got.cop).all()
    assert (got.foot_grf > 0.0).all()
    assert (got.grf > 0.0).all()


def test_an_offset_pattern_that_cancels_is_harmless() -> None:
    """+ - - + of four cells on a rectangle changes neither force nor CoP."""
    shoe, parameters, readings, _ = case("nao_shoe", 4)
    pattern = np.zeros(16)
    pattern[8:12] = (1.0, -1.0, -1.0, 1.0)
    got = expected_error(
        shoe, SUPPORT, parameters.outputs(readings), readings, np.outer(pattern, pattern)
    )
    assert got.grf.max() < 1e-9
    assert got.foot_cop.max() < 1e-9


def test_arrays_that_do_not_belong_together_are_refused(shoe: Shoe) -> None:
    name = shoe.name
    shoe, parameters, readings, covariance = case(name, 5)
    outputs = parameters.outputs(readings)
    with pytest.raises(ShapeError, match="outputs"):
        expected_error(shoe, SUPPORT, outputs[:, 1:], readings, covariance)
    with pytest.raises(ShapeError, match="readings"):
        expected_error(shoe, SUPPORT, outputs, readings[:1], covariance)
    with pytest.raises(ShapeError, match="covariance"):
        expected_error(shoe, SUPPORT, outputs, readings, covariance[1:, 1:])
    with pytest.raises(ShoecalError, match="not finite"):
        expected_error(shoe, SUPPORT, outputs, readings, covariance * np.nan)
