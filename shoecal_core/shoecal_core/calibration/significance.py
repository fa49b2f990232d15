"""Are two sets of runs different? A stratified permutation test whose unit is the run.

Samples of one run carry one common error for seconds, so thousands of them are not thousands
of witnesses: each run counts once, by its mean absolute error. Were the sets drawn at random and
nothing overfitted, any other split of a session's runs would have been as likely: the test
counts how many splits differ at least as much as the one at hand (Pitman 1937; Good,
Permutation, Parametric and Bootstrap Tests of Hypotheses, 2005). Sessions are the strata: runs
change places only within their own session, so that what distinguishes robots plays no part.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import ShoecalError

FloatArray = NDArray[np.float64]
Stratum = tuple[FloatArray, FloatArray]
"""Run-level figures of one session: of the first set, of the second."""

LEVEL = 0.95
MOST_SPLITS = 20_000
"""Up to so many splits all are tried; of more, `DRAWS` are drawn."""
DRAWS = 20_000
_ROUNDING = 1e-12
"""Splits that differ by this share of the figures alone count as equally far apart."""


@dataclass(frozen=True)
class Difference:
    """How the second set differs from the first.

    Attributes:
        value: mean over sessions of (mean of the second set's runs - mean of the first's).
        interval: of that difference at 95 %: the shifts that the test does not refuse; infinite
            where there are too few splits to refuse any.
        p_value: two-sided.
        smallest_p: the smallest that so few runs could have given at all.
        splits: tried.
        exact: these were all splits that there are.
        sessions, first, second: how many sessions, and runs in each set, it rests on.
    """

    value: float
    interval: tuple[float, float]
    p_value: float
    smallest_p: float
    splits: int
    exact: bool
    sessions: int
    first: int
    second: int

    @property
    def significant(self) -> bool:
        """Refused at 5 %."""
        return self.p_value <= 1.0 - LEVEL


def compare_sets(strata: Sequence[Stratum], generator: np.random.Generator) -> Difference | None:
    """Test whether two sets of runs differ, sessions being the strata.

    A session counts by how much its runs can tell, n1 n2 / (n1 + n2); one that lacks either set
    tells nothing.

    Args:
        strata: by session, figures (n1,) and (n2,) of its runs, all finite.
        generator: draws splits where there are too many to try them all.

    Returns:
        None where no session has runs in both sets.

    Raises:
        ShoecalError: for a figure that is not finite.
    """
    told = [(np.asarray(one), np.asarray(other)) for one, other in strata]
    told = [stratum for stratum in told if all(map(len, stratum))]
    if not told:
        return None
    if not all(np.isfinite(part).all() for stratum in told for part in stratum):
        raise ShoecalError("a run without a figure cannot be tested; leave it out")
    count = math.prod(_splits(stratum) for stratum in told)
    exact = count <= MOST_SPLITS
    chosen = _all_splits(told) if exact else _drawn_splits(told, generator)
    weights = np.array([len(one) * len(other) / (len(one) + len(other)) for one, other in told])
    value, interval, p_value = _test(told, chosen, weights / weights.sum())
    mirrored = exact and all(len(one) == len(other) for one, other in told)
    return Difference(
        value=value,
        interval=interval,
        p_value=p_value,
        smallest_p=(2 if mirrored else 1) / len(chosen[0]),
        splits=len(chosen[0]),
        exact=exact,
        sessions=len(told),
        first=sum(len(one) for one, _ in told),
        second=sum(len(other) for _, other in told),
    )


def _splits(stratum: Stratum) -> int:
    return math.comb(len(stratum[0]) + len(stratum[1]), len(stratum[1]))


def _all_splits(strata: Sequence[Stratum]) -> list[FloatArray]:
    """By stratum (splits, n): 1 for a run that falls to the second set; first the true split."""
    rows = [_membership(stratum) for stratum in strata]
    order = np.array(list(product(*(range(len(row)) for row in rows))))
    return [row[order[:, index]] for index, row in enumerate(rows)]


def _membership(stratum: Stratum) -> FloatArray:
    one, other = map(len, stratum)
    chosen = np.array(list(combinations(range(one + other), other)))
    rows = np.zeros((len(chosen), one + other))
    rows[np.arange(len(chosen))[:, None], chosen] = 1.0
    # The true split has the last places, and combinations come in order.
    return rows[::-1]


def _drawn_splits(strata: Sequence[Stratum], generator: np.random.Generator) -> list[FloatArray]:
    """As `_all_splits`, drawn; the true split is one of them, or p could be zero."""
    drawn = []
    for one, other in strata:
        true = np.repeat((0.0, 1.0), (len(one), len(other)))
        drawn.append(np.vstack((true, generator.permuted(np.tile(true, (DRAWS - 1, 1)), axis=1))))
    return drawn


def _test(
    strata: Sequence[Stratum], chosen: Sequence[FloatArray], weights: FloatArray
) -> tuple[float, tuple[float, float], float]:
    """Difference, its interval, p value.

    Were the second set shifted by d, a split would differ by A - d B: A from the figures, B from
    the share of the second set that the split left there (1 for the true split). The split is
    as far apart as the true one where |A - d B| >= |value - d|: for all d between two bounds that
    are known in closed form. The test refuses each d that too few splits cover.
    """
    differs = np.zeros(len(chosen[0]))
    left_there = np.zeros_like(differs)
    for (one, other), rows, weight in zip(strata, chosen, weights, strict=True):
        contrast = weight * (rows / len(other) - (1.0 - rows) / len(one))
        differs += contrast @ np.concatenate((one, other))
        left_there += contrast @ np.repeat((0.0, 1.0), (len(one), len(other)))
    value = float(differs[0])
    rounding = _ROUNDING * max(np.abs(part).max() for stratum in strata for part in stratum)
    p_value = float(np.mean(np.abs(differs) >= abs(value) - rounding))
    beyond = differs - left_there * value
    with np.errstate(divide="ignore", invalid="ignore"):
        bounds = np.stack((beyond / (1.0 + left_there), -beyond / (1.0 - left_there)))
    unbounded = np.abs(left_there) > 1.0 - _ROUNDING
    high = np.where(unbounded, np.inf, bounds.max(axis=0))
    low = np.where(unbounded, -np.inf, bounds.min(axis=0))
    refused = math.floor((1.0 - LEVEL) * len(differs) * (1.0 + 1e-12))
    interval = value + np.array((np.sort(low)[refused], np.sort(high)[-1 - refused]))
    return value, (float(interval[0]), float(interval[1])), p_value
