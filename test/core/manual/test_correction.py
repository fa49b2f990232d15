from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.manual.benches import nao_shoe, read_shoe, some_law
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.manual.correction import fit_correction
from shoecal_core.manual.loads import SHOE
from shoecal_core.manual.measurements import Measurements
from shoecal_core.manual.shoe_loads import ShoeLoads, loaded
from shoecal_core.shoe.correction import CopCorrection

WEIGHTS = (1.0, 2.0, 3.0, 4.0)


def bench(foot: int = 0) -> tuple[Measurements, ShoeLoads]:
    shoe = nao_shoe()
    law = some_law(shoe)
    loads = read_shoe(shoe, law, WEIGHTS)
    return loads, loaded(loads, foot, law)


def some_correction(seed: int, foot: int = 0) -> CopCorrection:
    """A few millimetres at every term."""
    rng = np.random.default_rng(seed)
    size = np.array([2.0, 0.05, 0.05, 2e-3, *[1e-4] * 4])
    ranges = np.zeros((2, 2)), np.zeros((2, 4))
    return CopCorrection(foot, rng.normal(0, size), rng.normal(0, size), *ranges)


def corrected(correction: CopCorrection, found: ShoeLoads) -> FloatArray:
    """(N, 2) CoP of the loads [m]."""
    return np.stack(correction.correct(list(found.cop.T), list(found.outputs.T)), axis=1)


def bent(found: ShoeLoads, by: CopCorrection) -> ShoeLoads:
    """Loads that this correction puts right."""
    return dataclasses.replace(found, expected_cop=corrected(by, found))


@given(st.integers(0, 2**32 - 1), st.sampled_from([0, 1]))
@settings(max_examples=30)
def test_what_is_linear_in_the_terms_is_found(seed: int, foot: int) -> None:
    loads, found = bench(foot)
    found = bent(found, some_correction(seed, foot))
    fit = fit_correction(loads, found)
    np.testing.assert_allclose(fit.corrected, found.expected_cop, atol=2e-5)
    np.testing.assert_allclose(corrected(fit.correction, found), fit.corrected, atol=1e-12)


def test_no_smaller_cost_beside_it() -> None:
    """Eq. 6 at its minimum: no step in any parameter lowers the sum of squares by much."""
    loads, found = bench()
    rng = np.random.default_rng(1)
    target = found.expected_cop + rng.normal(0.0, 6e-4, found.cop.shape)
    found = dataclasses.replace(found, expected_cop=target)
    fit = fit_correction(loads, found).correction

    def cost(correction: CopCorrection) -> float:
        error = corrected(correction, found) - target
        return float((error**2).sum())

    least = cost(fit)
    for _ in range(200):
        step = some_correction(int(rng.integers(2**32)))
        away = dataclasses.replace(fit, x=fit.x + 0.05 * step.x, y=fit.y + 0.05 * step.y)
        assert cost(away) > least * (1.0 - 1e-4)


def test_held_out_is_a_fit_without_that_load() -> None:
    loads, found = bench()
    rng = np.random.default_rng(1)
    found = dataclasses.replace(
        found, expected_cop=found.expected_cop + rng.normal(0.0, 6e-4, found.cop.shape)
    )
    fit = fit_correction(loads, found)
    for left_out in (0, 17, 40):
        keep = np.arange(len(found.loads)) != left_out
        others = dataclasses.replace(
            found,
            loads=tuple(load for load, kept in zip(found.loads, keep, strict=True) if kept),
            **{
                name: getattr(found, name)[keep]
                for name in ("outputs", "force", "cop", "expected_force", "expected_cop")
            },
        )
        alone = fit_correction(loads, others).correction
        predicted = alone.correct(found.cop[left_out], found.outputs[left_out])
        np.testing.assert_allclose(predicted, fit.held_out[left_out], atol=1e-9)


def test_terms_that_no_load_tells_stay_small() -> None:
    """A stiff plate never makes the pattern + - - +: noise must not become its coefficient."""
    loads, found = bench()
    rng = np.random.default_rng(1)
    noisy = dataclasses.replace(
        found,
        outputs=found.outputs + rng.normal(0.0, 1e-3, found.outputs.shape),
        expected_cop=found.expected_cop + rng.normal(0.0, 6e-4, found.cop.shape),
    )
    fit = fit_correction(loads, noisy).correction
    # A newton shifted in that pattern moves the CoP by less than a tenth of a millimetre.
    pattern = np.linalg.svd(loads.shoe.columns[:4].T)[2][3]
    assert abs(fit.x[4:] @ pattern) < 1e-4
    assert abs(fit.y[4:] @ pattern) < 1e-4


def test_it_knows_where_it_was_trained() -> None:
    loads, found = bench()
    correction = fit_correction(loads, found).correction
    places, outputs = found.cop.T, list(found.outputs.T)
    assert not np.any(correction.extrapolates(list(places), outputs))
    assert np.all(correction.extrapolates(list(places + 0.2), outputs))
    assert np.any(correction.extrapolates(list(places), [3.0 * one for one in outputs]))


# ---- refused ----------------------------------------------------------------------------------


def some_of(loads: Measurements, holes: str, weights: tuple[float, ...]) -> Measurements:
    """Bare shoes, and some weights in holes with some letters and numbers."""
    entries = tuple(
        entry
        for entry in loads.entries
        if not entry.load.place
        or (entry.load.mass in weights and all(part in holes for part in entry.load.place))
    )
    return Measurements(SHOE, loads.shoe, entries)


@pytest.mark.parametrize(
    ("holes", "weights", "problem"),
    [
        ("abcdef123", (2.0,), "18 loads in 6 rows and 3 columns of holes, of 1 weight"),
        ("ab123", WEIGHTS, "24 loads in 2 rows"),
        ("abcdef12", WEIGHTS, "in 6 rows and 2 columns"),
        ("a1", (1.0, 2.0), "2 loads in 1 rows"),
    ],
)
def test_too_few_to_fix_it(holes: str, weights: tuple[float, ...], problem: str) -> None:
    loads, _ = bench()
    few = some_of(loads, holes, weights)
    with pytest.raises(ShoecalError, match="left shoe: ") as caught:
        fit_correction(few, loaded(few, 0, some_law(loads.shoe)))
    assert problem in str(caught.value)


def test_few_that_fix_it_are_enough() -> None:
    loads, _ = bench()
    few = some_of(loads, "ace123", (1.0, 4.0))
    fit_correction(few, loaded(few, 0, some_law(loads.shoe)))


def test_many_in_a_pattern_that_leaves_something_open() -> None:
    """Three rows, three columns and two weights, yet all holes on two lines."""
    loads, _ = bench()
    diagonal = ("a1", "c2", "e3", "e1", "a3")
    entries = tuple(
        entry
        for entry in loads.entries
        if not entry.load.place
        or (entry.load.place in diagonal and entry.load.mass == 1.0)
        or (entry.load.place == "a1" and entry.load.mass == 4.0)
    )
    few = Measurements(SHOE, loads.shoe, entries)
    with pytest.raises(ShoecalError, match="6 loads do not fix the correction"):
        fit_correction(few, loaded(few, 0, some_law(loads.shoe)))


def test_a_weight_in_another_hole_is_named() -> None:
    loads, found = bench()
    rng = np.random.default_rng(1)
    noisy = found.expected_cop + rng.normal(0.0, 6e-4, found.cop.shape)
    fit_correction(loads, dataclasses.replace(found, expected_cop=noisy))
    index = next(
        index for index, load in enumerate(found.loads) if (load.place, load.mass) == ("c2", 3.0)
    )
    stood = next(
        index for index, load in enumerate(found.loads) if (load.place, load.mass) == ("d2", 3.0)
    )
    cop = found.cop.copy()
    cop[index] = cop[stood]
    outputs = found.outputs.copy()
    outputs[index] = outputs[stood]
    wrong = dataclasses.replace(found, cop=cop, outputs=outputs, expected_cop=noisy)
    with pytest.raises(ShoecalError, match=r"left shoe, 3 kg in hole c2: .* near hole d2"):
        fit_correction(loads, wrong)
