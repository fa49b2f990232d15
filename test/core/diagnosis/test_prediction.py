"""Predictions of runs left out against Gaussian densities of whole vectors, and by their truth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import cho_factor, cho_solve
from scipy.stats import multivariate_normal

from core.diagnosis.drawn import Urn, part
from core.diagnosis.test_scoring import ROWS, STD, possible, rows
from shoecal_core.diagnosis.prediction import BUILT_WITHIN, ROUNDS, log_predictive, within_tolerance
from shoecal_core.diagnosis.scoring import Scorer
from shoecal_core.diagnosis.spread import COUNTS, log_likelihood, most_probable

SIZE = np.array([0.0, 0.3, -0.4, 0.0])


@pytest.mark.parametrize("noise", [0.5, 1.0, 3.0])
def test_a_prediction_is_the_density_of_all_rows(noise: float) -> None:
    """Up to a constant, under the variances that the rows most probably have."""
    others = rows(2, noise, size=SIZE)
    scorer = Scorer(rows(1, size=SIZE), 0, others)
    one = possible((1, 2), STD)
    found = []
    for parts in ([], [(one, one.forms[0])]):
        scored = scorer.score(parts)
        matrix = np.column_stack((others.base, others.columns[:, list(scored.columns)]))
        rest = others.residuals - matrix @ scored.vector
        expected = scored.expected
        spread = matrix @ scored.covariance @ matrix.T
        # Rows vary by what is not known of them: the fixed point of their variances.
        variance = expected
        for _ in range(2 * ROUNDS):
            whole = np.diag(variance[others.group] / COUNTS) + spread
            moved = spread @ cho_solve(cho_factor(whole), rest)
            power = others.squares(rest - moved)
            variance = most_probable(power, expected, others.count, others.most)
        likely = log_likelihood(variance, power, expected, others.count)
        density = multivariate_normal(np.zeros(ROWS), whole).logpdf(rest)
        each = (COUNTS / variance)[others.group]
        alone = -0.5 * float((each * (rest - moved) ** 2).sum())
        alone += 0.5 * float(np.log(each / (2.0 * np.pi)).sum())
        # What the density has beyond the rows' own, added to what the rows are worth.
        wanted = float(likely.sum()) + density - alone
        found.append((log_predictive(scored), wanted))
    for told, wanted in found:
        assert told == pytest.approx(wanted, abs=0.05)


@pytest.mark.parametrize("seed", range(4))
def test_what_is_true_predicts_runs_left_out(urn: Urn, seed: int) -> None:
    drawn = urn.draw(np.random.default_rng(seed), {"floor_tilt": [0.06, 0.05]})
    scorer = drawn.scorer
    told = {
        label: log_predictive(scorer.score([part(drawn, label)]))
        for label in ("floor_tilt", "latency (left)", "hysteresis (right)")
    }
    least = log_predictive(scorer.nothing)
    assert told.pop("floor_tilt") > least + 3.0
    assert max(told.values()) < least + 3.0


def test_without_a_fault_the_same_error_as_built_is_no_larger_than_its_tolerance(urn: Urn) -> None:
    """It would predict as well as the fault otherwise, however improbable it is."""
    drawn = urn.draw(np.random.default_rng(3), {"latency (all)": [0.15]})
    scorer = drawn.scorer
    found = log_predictive(scorer.score([part(drawn, "latency (all)")]))
    kept, alike = within_tolerance(scorer.nothing), 6.0
    assert log_predictive(scorer.nothing) > found - alike
    assert log_predictive(kept) < found - alike
    most = BUILT_WITHIN / np.sqrt(scorer.rows.precision)
    built = scorer.rows.built
    assert (np.abs(kept.vector) <= most)[built].all()
    np.testing.assert_array_equal(kept.vector[~built], scorer.nothing.vector[~built])


@pytest.mark.parametrize("seed", range(4))
def test_of_noise_nothing_predicts_more(urn: Urn, seed: int) -> None:
    drawn = urn.draw(np.random.default_rng(100 + seed))
    least = log_predictive(drawn.scorer.nothing)
    for label in ("floor_tilt", "latency (left)", "link_com (Neck_link)"):
        scored = drawn.scorer.score([part(drawn, label)])
        assert log_predictive(scored) < least + 3.0
