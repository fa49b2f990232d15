"""How well runs that were left out are predicted, by an explanation and without it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.rows import Rows
from shoecal_core.diagnosis.scoring import SETTLED, Scored
from shoecal_core.diagnosis.spread import COUNTS, log_likelihood, most_probable
from shoecal_core.error_sources.posterior import Posterior
from shoecal_core.error_sources.signals import SIGNALS
from shoecal_core.error_sources.spectrum import BANDS

ROUNDS = 6
"""Steps by which the variances of bands settle."""
BUILT_WITHIN = 3.0
"""Times its tolerance, a standard deviation, that a tolerance error may be: what is larger is none.
One in 370 is on a robot as declared; at 2 some are on any, and one built twice as badly alarms."""


def within_tolerance(scored: Scored) -> Scored:
    """The same fit with errors that are no larger than tolerances allow.

    A tolerance error that is the same as a fault, or nearly, would predict as well as the fault;
    and a wrong cause next to it would seem to.
    """
    rows = scored.scorer.rows
    most = np.where(rows.built, BUILT_WITHIN / np.sqrt(rows.precision), np.inf)
    vector = scored.vector.copy()
    vector[: len(most)] = np.clip(vector[: len(most)], -most, most)
    return replace(scored, vector=vector)


def log_predictive(scored: Scored) -> float:
    """Logarithm of the probability of runs left out, under what was fitted to others.

    Gains, offsets, tolerance errors and sizes have the distribution that the fit left them; bands
    have the variance that it expected, known to a factor as there (`scoring`).

    Args:
        scored: the fit.

    Returns:
        Up to a constant that is the same for all fits.
    """
    scorer, rows = scored.scorer, scored.scorer.withheld
    assert rows is not None, "no runs were left out"
    columns = rows.columns[:, list(scored.columns)]
    base = np.column_stack((scorer.withheld_base, columns)) @ scorer.reduced_root(scored)
    residuals = rows.residuals - np.column_stack((rows.base, columns)) @ scored.vector
    expected = _expected(rows, scored)
    variance, log = expected, 0.0
    for _ in range(ROUNDS):
        weight = (COUNTS / variance)[rows.group][:, None]
        posterior = Posterior(base.T @ (weight * base), np.ones(base.shape[1]))
        moved = posterior.solve(base.T @ (weight[:, 0] * residuals))
        power = rows.squares(residuals - base @ moved)
        variance = most_probable(power, expected, rows.count, rows.most)
        likely = log_likelihood(variance, power, expected, rows.count)
        before, log = log, float(likely.sum() - 0.5 * moved @ moved) - posterior.half_log_volume
        if abs(log - before) < SETTLED:
            break
    return log


def _expected(rows: Rows, scored: Scored) -> FloatArray:
    """(G,) variance of the groups; of those that the fit had none of, as usual."""
    missing = np.zeros((len(SIGNALS), BANDS))
    usual = rows.by_band(rows.noise + rows.smooth + rows.form, missing)
    expected = scored.scorer.rows.by_band(scored.expected, usual)
    return expected.ravel()[rows.number]
