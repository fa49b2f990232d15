"""The baseline in fewer columns says what all of its columns say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from core.diagnosis.test_scoring import (
    BASE,
    BUILT,
    ROWS,
    SETTLED,
    STD,
    log_density,
    possible,
    rows,
)
from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.basis import make_basis
from shoecal_core.diagnosis.rows import Rows
from shoecal_core.diagnosis.scoring import Scorer

ALIKE = 80


def redundant(seed: int, built: float) -> Rows:
    """As-built errors that are mixtures of a few, the later ones ever smaller."""
    what, rng = rows(seed, built=built), np.random.default_rng(seed)
    mixed = what.base[:, BASE:] @ rng.normal(size=(BUILT, ALIKE)) * 0.8 ** np.arange(ALIKE)
    count = BASE + ALIKE
    return replace(
        what,
        base=np.hstack((what.base[:, :BASE], mixed)),
        away=np.zeros(count),
        precision=np.concatenate((what.precision[:BASE], np.full(ALIKE, 4.0))),
        built=np.arange(count) >= BASE,
        family=np.where(np.arange(count) < BASE, -1, 0),
    )


@pytest.mark.parametrize(("seed", "built"), [(1, 0.0), (2, 1.0), (3, 3.0)])
def test_evidence_is_that_of_all_columns(seed: int, built: float) -> None:
    what = redundant(seed, built)
    scorer, one = Scorer(what, 0), possible((1, 2), STD)
    assert scorer.basis.columns.shape[1] <= BASE + BUILT
    nothing = scorer.score([], rounds=SETTLED)
    found = scorer.score([(one, one.forms[0])], start=nothing, rounds=SETTLED)
    wanted = log_density(found, what) - log_density(nothing, what)
    assert found.evidence == pytest.approx(wanted, abs=0.05)


def test_unknowns_are_the_most_probable_errors() -> None:
    """And what no row shows keeps its mean of zero."""
    what = redundant(4, 1.0)
    unseen = what.base.copy()
    unseen[:, -3:] = 0.0
    what = replace(what, base=unseen)
    scored = Scorer(what, 0).nothing
    weight = 1.0 / scored.variance[what.group]
    precision = what.prior(scored.levels)
    normal = 0.15 * (what.base.T * weight) @ what.base + np.diag(precision)
    wanted = np.linalg.solve(normal, 0.15 * what.base.T @ (weight * what.residuals))
    assert_allclose(scored.vector, wanted, atol=2e-3)
    assert not scored.vector[-3:].any()


def test_columns_that_stay_come_first_and_as_they_are() -> None:
    what = redundant(5, 1.0)
    basis = make_basis(what, BASE)
    assert_allclose(basis.columns[:, :BASE], what.base[:, :BASE])
    unknowns: FloatArray = np.random.default_rng(5).normal(size=(basis.columns.shape[1],))
    assert_allclose(what.base @ basis.whole(unknowns), basis.columns @ unknowns, atol=1e-9 * ROWS)
