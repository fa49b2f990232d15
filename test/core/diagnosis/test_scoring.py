"""Evidence and foretelling against Gaussian densities of whole vectors."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import multivariate_normal

from core.error_sources.test_regression import BASE, ROWS, RUNS, dense
from shoecal_core.diagnosis.hypotheses import Form, Hypothesis
from shoecal_core.diagnosis.scoring import Reduced, Scorer
from shoecal_core.error_sources.base import Shape
from shoecal_core.error_sources.effects.contact import FloorTilt

FloatArray = NDArray[np.float64]
STD = np.array([0.5, 2.0])


def possible(columns: tuple[int, ...], std: FloatArray, forms: int = 1) -> Hypothesis:
    """A hypothesis with some of the random columns."""
    shape = Shape(("a", "b")[: len(columns)], np.zeros((len(columns), 1, 1)))
    form = Form(shape, columns, std, np.full(len(std), -np.inf), np.full(len(std), np.inf))
    return Hypothesis(FloorTilt(), (), (form,) * forms, 1.0)


def density(values: FloatArray, mean: FloatArray, covariance: FloatArray) -> float:
    return float(multivariate_normal(mean, covariance).logpdf(values))


def believed(whole: FloatArray, precision: FloatArray, columns: tuple[int, ...]) -> FloatArray:
    """(N, N) covariance of all rows before anything is measured, over the noise's variance."""
    matrix = whole[:, [*range(BASE), *(BASE + one for one in columns)]]
    prior = np.concatenate((1.0 / precision, STD[: len(columns)] ** 2))
    return np.asarray(np.eye(len(whole)) + (matrix * prior) @ matrix.T)


@pytest.mark.parametrize("noise", [0.5, 1.0, 4.0])
def test_evidence_is_the_density_of_all_rows(noise: float) -> None:
    sums, whole, precision = dense(1)
    reduced = Reduced(sums.of(sums.runs)[0], sums)
    values, nothing = whole[:, -1], np.zeros(len(whole))
    usual = noise * believed(whole, precision, ())
    truth = density(values, nothing, noise * believed(whole, precision, (1, 2)))
    truth -= density(values, nothing, usual)
    with_, without = reduced.fit((1, 2), STD), reduced.fit((), np.zeros(0))
    found = reduced.log_evidence(with_, noise) - reduced.log_evidence(without, noise)
    assert found == pytest.approx(truth, rel=1e-6)


def test_evidence_with_noise_as_large_as_what_is_left() -> None:
    sums, whole, _ = dense(4)
    scorer = Scorer(sums, sums.runs)
    alone = possible((0, 2), STD)
    found = scorer.score([(alone, alone.forms[0])])
    reduced = Reduced(scorer.products, sums)
    fit, nothing = reduced.fit((0, 2), STD), reduced.fit((), np.zeros(0))
    wanted = 0.5 * len(whole) * math.log(nothing.squares / fit.squares) - fit.log_volume
    assert found.evidence == pytest.approx(wanted)
    np.testing.assert_allclose(found.sizes, found.solution.vector[-2:], rtol=1e-6)
    assert fit.squares == pytest.approx(found.solution.squares)
    assert fit.log_volume == pytest.approx(found.solution.log_volume)
    # Each form that was tried costs.
    many = possible((0, 2), STD, forms=3)
    assert scorer.best_form(many).evidence == pytest.approx(wanted - math.log(3))


def test_what_is_foretold_is_each_run_s_density_given_the_others() -> None:
    sums, whole, precision = dense(5)
    scorer = Scorer(sums, sums.runs)
    alone = possible((1, 3), STD)
    found = scorer.score([(alone, alone.forms[0])])
    noise = Reduced(scorer.products, sums).fit((1, 3), STD).squares / len(whole)
    values, total = whole[:, -1], 0.0
    for columns, sign in (((1, 3), 1.0), ((), -1.0)):
        covariance = noise * believed(whole, precision, columns)
        for run in range(RUNS):
            own = np.arange(len(whole)) // ROWS == run
            pull = covariance[np.ix_(own, ~own)] @ np.linalg.inv(covariance[np.ix_(~own, ~own)])
            rest = covariance[np.ix_(own, own)] - pull @ covariance[np.ix_(~own, own)]
            total += sign * density(values[own], pull @ values[~own], 0.5 * (rest + rest.T))
    assert found.foretold == pytest.approx(total, rel=1e-6)


def test_parts_find_their_own_sizes() -> None:
    sums, _, _ = dense(6)
    scorer = Scorer(sums, sums.runs)
    first, second = possible((0, 1), STD), possible((3,), STD[:1])
    found = scorer.score([(first, first.forms[0]), (second, second.forms[0])])
    assert found.columns == (0, 1, 3)
    assert found.sizes[found.own(0)].tolist() == found.sizes[:2].tolist()
    assert found.sizes[found.own(1)].tolist() == found.sizes[2:].tolist()


def test_a_size_below_its_least_makes_no_sense() -> None:
    sums, _, _ = dense(7)
    scorer = Scorer(sums, sums.runs)
    alone = possible((0,), STD[:1])
    size = float(scorer.best_form(alone).sizes[0])
    for least, sensible in ((size - 1.0, True), (size + 1.0, False)):
        form = Form(alone.forms[0].shape, (0,), STD[:1], np.array([least]), np.array([np.inf]))
        assert scorer.score([(alone, form)]).sensible is sensible
