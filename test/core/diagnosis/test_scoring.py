"""Evidence against Gaussian densities of whole vectors; what noise and scale may not do."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.hypotheses import Form, Hypothesis
from shoecal_core.diagnosis.rows import Rows
from shoecal_core.diagnosis.scoring import LEVEL, LEVEL_FREEDOM, Scored, Scorer
from shoecal_core.diagnosis.spread import COUNTS, FREEDOM, MODEL_LEVELS
from shoecal_core.error_sources.base import Shape
from shoecal_core.error_sources.effects.contact import FloorTilt
from shoecal_core.error_sources.signals import CLOSURE, PARITY
from shoecal_core.error_sources.spectrum import BANDS

ROWS, BASE, BUILT, MORE = 1200, 4, 6, 4
STD = np.array([0.5, 2.0])
CLOSURES = CLOSURE.start * BANDS + np.arange(3)
PARITIES = PARITY.start * BANDS + np.arange(3)
SETTLED = 60
"""Rounds after which a fit moves no more."""


def rows(seed: int, noise: float = 1.0, size: FloatArray | None = None, built: float = 0.0) -> Rows:
    """Random columns in three bands of one signal, with noise of unit deviation.

    Args:
        noise: variance that is expected. size: (MORE,) what effects add. built: as-built level.
    """
    rng = np.random.default_rng(seed)
    base, columns = rng.normal(size=(ROWS, BASE + BUILT)), rng.normal(size=(ROWS, MORE))
    residuals = rng.normal(size=ROWS) + base[:, :BASE] @ rng.normal(size=BASE)
    residuals += built * base[:, BASE:] @ rng.normal(size=BUILT)
    residuals += columns @ (np.zeros(MORE) if size is None else size)
    group = np.arange(ROWS) * 3 // ROWS
    return Rows(
        base=base,
        columns=columns,
        residuals=residuals,
        away=np.zeros(BASE + BUILT),
        measured=np.zeros(ROWS),
        group=group,
        number=CLOSURES,
        noise=np.full(3, noise),
        form=np.zeros(3),
        smooth=np.zeros(3),
        most=np.full(3, 100.0),
        precision=np.concatenate((np.full(BASE, 1e-4), np.ones(BUILT))),
        built=np.repeat([False, True], [BASE, BUILT]),
        family=np.repeat([-1, 0], [BASE, BUILT]),
        most_level=np.array([4.0]),
        same=np.full(MORE, -1),
    )


def possible(columns: tuple[int, ...], std: FloatArray, forms: int = 1) -> Hypothesis:
    """A hypothesis with some of the random columns."""
    shape = Shape(("a", "b")[: len(columns)], np.zeros((len(columns), 1, 1)))
    form = Form(shape, columns, std, np.full(len(std), -np.inf), np.full(len(std), np.inf))
    return Hypothesis(FloorTilt(), (), (form,) * forms, 1.0)


def log_density(scored: Scored, what: Rows) -> float:
    """Of all rows, each of which counts for a share of one, under the variances and levels that a
    fit ended with, and of these.
    """
    matrix = np.column_stack((what.base, what.columns[:, list(scored.columns)]))
    prior = np.concatenate((1.0 / what.prior(scored.levels), scored.std**2))
    variance = scored.variance[what.group]
    covariance = np.diag(variance / COUNTS) + (matrix * prior) @ matrix.T
    found = multivariate_normal(np.zeros(ROWS), covariance).logpdf(what.residuals)
    found += 0.5 * (1.0 - COUNTS) * float(np.log(variance).sum())
    ratio = scored.variance / scored.expected
    found -= 0.5 * FREEDOM * float((np.log(ratio) + 1.0 / ratio - 1.0).sum())
    level = float(scored.levels[0]) / LEVEL
    found -= 0.5 * LEVEL_FREEDOM * (2.0 * math.log(level) + level**-2.0 - 1.0)
    return float(found - 0.5 * (np.log(scored.form_level) ** 2).sum())


@pytest.mark.parametrize(("seed", "built"), [(1, 0.0), (2, 1.0), (3, 3.0)])
def test_evidence_is_the_density_of_all_rows(seed: int, built: float) -> None:
    what = rows(seed, size=np.array([0.0, 0.3, -0.4, 0.0]), built=built)
    scorer = Scorer(what, 0)
    one = possible((1, 2), STD)
    nothing = scorer.score([], rounds=SETTLED)
    found = scorer.score([(one, one.forms[0])], start=nothing, rounds=SETTLED)
    wanted = log_density(found, what) - log_density(nothing, what)
    assert found.evidence == pytest.approx(wanted, abs=0.05)
    # Each form that was tried costs.
    many = possible((1, 2), STD, forms=3)
    costly = scorer.score([(many, many.forms[0])], start=nothing, rounds=SETTLED)
    assert costly.evidence == pytest.approx(found.evidence - math.log(3))


@pytest.mark.parametrize("seed", range(6))
def test_further_steps_and_what_contains_more_are_no_worse(seed: int) -> None:
    """Also where a few bands are far noisier than the others, which lets a fit turn in circles."""
    rng = np.random.default_rng(seed)
    what = replace(rows(seed, built=1.0), smooth=np.ones(3))
    what.residuals[: ROWS // 3] *= float(rng.uniform(1.0, 100.0))
    scorer = Scorer(what, 0)
    assert scorer.unmodelled.evidence >= 0.0
    one = possible((1, 2), STD)
    for unmodelled in (False, True):
        each = [
            scorer.score([(one, one.forms[0])], unmodelled=unmodelled, rounds=rounds).evidence
            for rounds in (1, 2, 3, 5, 10, 20)
        ]
        assert each == sorted(each)


def test_of_noise_nothing_is_evident() -> None:
    """However large it is against what was expected."""
    for noise in (0.1, 1.0, 10.0):
        scorer = Scorer(rows(4, noise), 0)
        for column in range(MORE):
            one = possible((column,), STD[:1])
            assert scorer.score([(one, one.forms[0])]).evidence < 3.0
        assert scorer.unmodelled.evidence < (3.0 if noise >= 1.0 else np.inf)


def test_sizes_and_their_places() -> None:
    size = np.array([0.8, -0.7, 0.0, 0.6])
    scorer = Scorer(rows(5, size=size), 0)
    first, second = possible((0, 1), STD), possible((3,), STD[:1])
    found = scorer.score([(first, first.forms[0]), (second, second.forms[0])])
    assert found.columns == (0, 1, 3)
    assert found.sizes[found.own(0)].tolist() == found.sizes[:2].tolist()
    assert found.sizes[found.own(1)].tolist() == found.sizes[2:].tolist()
    spread = np.sqrt(np.diag(found.covariance)[-3:])
    assert (np.abs(found.sizes - size[[0, 1, 3]]) < 4.0 * spread).all()
    best = max(scorer.gains([first, second]), key=lambda one: one.gain)
    assert 0.3 < best.gain / scorer.score(best.parts[:1]).evidence < 3.0


def test_forms_that_look_alike_cost_nothing_by_their_number() -> None:
    """A law that may have seven forms is as probable as one with one, where all seven fit alike."""
    scorer = Scorer(rows(5, size=np.array([0.8, 0.0, 0.0, 0.0])), 0)
    one, seven = scorer.gains([possible((0,), STD[:1], forms) for forms in (1, 7)])
    assert one.alike == 0.0
    assert seven.gain + seven.alike == pytest.approx(one.gain)
    assert seven.gain < one.gain


def test_levels_follow_what_the_robot_shows() -> None:
    levels = [float(Scorer(rows(6, built=one), 0).nothing.levels[0]) for one in (0.0, 0.5, 3.0)]
    assert levels == sorted(levels)
    assert levels[0] < 0.5
    assert levels[2] > 1.5


def test_how_much_a_model_lacks_is_found() -> None:
    """Where it lacks less than models usually do, smaller effects show."""
    what, rng = rows(10, 0.01), np.random.default_rng(11)
    what.residuals[:] = 0.05 * what.columns[:, 0] + 0.1 * rng.normal(size=ROWS)
    one, usual = possible((0,), STD[:1]), np.ones(3)
    exact = Scorer(replace(what, smooth=usual, number=PARITIES), 0)
    assert (exact.nothing.model_level == MODEL_LEVELS[-1]).all()
    rough = replace(what, smooth=usual, number=PARITIES, residuals=10.0 * what.residuals)
    assert (Scorer(rough, 0).nothing.model_level == 1.0).all()
    # Of a body no model is so good, however well it fits.
    assert (Scorer(replace(what, smooth=usual), 0).nothing.model_level == 1.0).all()
    assert exact.score([(one, one.forms[0])]).evidence > 5.0


def test_an_unmodelled_term_is_evident_where_no_column_is() -> None:
    rng = np.random.default_rng(7)
    what = replace(rows(7), most=np.full(3, 4.0), smooth=np.ones(3))
    third = ROWS // 3
    what.residuals[:third] += 8.0 * rng.normal(size=third)
    scorer = Scorer(what, 0)
    assert scorer.unmodelled.evidence > 20.0
    one = possible((0,), STD[:1])
    assert scorer.score([(one, one.forms[0])]).evidence < 5.0


def test_a_scale_that_shrinks_what_is_measured_is_no_explanation() -> None:
    """Were residuals counted as they stand, gains and a model that shrink would look right."""
    rng = np.random.default_rng(8)
    what = rows(8)
    model = 2.0 * rng.normal(size=ROWS)
    measured = model + rng.normal(size=ROWS)
    what.base[:, 0], what.columns[:, 0] = measured, -model
    what.base[:, 1:] = 0.0
    what.residuals[:] = measured - model
    what.measured[:] = measured
    one = possible((0,), STD[:1])
    parts = [(one, one.forms[0])]
    assert Scorer(what, 1).score(parts).evidence < 0.0
    assert Scorer(what, 0).score(parts).evidence > 3.0


def test_a_size_below_its_least_makes_no_sense() -> None:
    scorer = Scorer(rows(9, size=np.array([0.8, 0.0, 0.0, 0.0])), 0)
    for least, sensible in ((0.2, True), (1.5, False)):
        form = Form(
            Shape(("a",), np.zeros((1, 1, 1))), (0,), STD[:1], np.array([least]), np.array([9.0])
        )
        one = Hypothesis(FloorTilt(), (), (form,), 1.0)
        assert scorer.score([(one, form)]).sensible is sensible
        assert bool(scorer.gains([one])) is sensible
