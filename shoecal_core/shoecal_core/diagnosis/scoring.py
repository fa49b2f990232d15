"""How well a hypothesis explains what runs show, and foretells runs it was not fitted on.

With whitened residuals the logarithm of a hypothesis' evidence is
    - N/2 log(squares / N)   less   what the data narrow its components' priors
with N the number of independent rows: the noise is as large as what is left, so that a noise that
was guessed too small accuses nobody.

How far a robot is off its files as it was built is not the same for all robots. Tolerances count at
several levels, each a factor on all of them; every explanation is judged at the level that suits it
best, volume of the tolerances' priors included. So a small fault stands out on a robot that is
otherwise exact, and the same deviation accuses nobody on one that is not.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular

from shoecal_core.diagnosis.hypotheses import Form, Hypothesis
from shoecal_core.error_sources.regression import Solution, Sums, solve

FloatArray = NDArray[np.float64]
Part = tuple[Hypothesis, Form]


@dataclass(frozen=True)
class Small:
    """A fit of a few columns.

    Attributes:
        sizes: (k,) of the columns.
        squares: left, priors included.
        log_volume: half the logarithm of how much the data narrow the priors of the columns and of
            the baseline.
    """

    sizes: FloatArray
    squares: float
    log_volume: float


class Reduced:
    """Sums of some runs, the baseline's columns fitted already whatever else is added.

    Args:
        products: (q, q) of the runs. sums: what they are of.
    """

    def __init__(self, products: FloatArray, sums: Sums) -> None:
        base = sums.base
        scale = 1.0 / np.sqrt(np.diag(products)[:base] + sums.precision)
        system = (products[:base, :base] + np.diag(sums.precision)) * np.outer(scale, scale)
        factor = np.linalg.cholesky(system + 1e-12 * np.eye(base))
        beside = solve_triangular(factor, scale[:, None] * products[:base, base:], lower=True)
        self._rest = products[base:, base:] - beside.T @ beside
        self._log_base = float(
            np.log(np.diag(factor)).sum() - np.log(scale).sum() - 0.5 * np.log(sums.precision).sum()
        )

    def fit(self, columns: Sequence[int], std: FloatArray) -> Small:
        """Some columns with priors, beside the baseline."""
        if not len(columns):
            return Small(np.zeros(0), float(self._rest[-1, -1]), self._log_base)
        chosen = np.asarray(columns, dtype=np.int64)
        matrix = np.eye(len(std)) + self._rest[np.ix_(chosen, chosen)] * np.outer(std, std)
        right = std * self._rest[chosen, -1]
        factor = np.linalg.cholesky(matrix)
        half = solve_triangular(factor, right, lower=True)
        sizes = std * solve_triangular(factor.T, half, lower=False)
        squares = float(self._rest[-1, -1] - half @ half)
        return Small(sizes, squares, self._log_base + float(np.log(np.diag(factor)).sum()))

    def log_evidence(self, fit: Small, noise: float) -> float:
        """Of the runs under noise of this variance, but for a constant."""
        return -0.5 * fit.squares / noise - fit.log_volume


@dataclass(frozen=True)
class Scored:
    """Some forms together, fitted.

    Attributes:
        scorer: what scored them.
        parts: hypotheses with the form chosen of each.
        sizes: (k,) of all their columns.
        level: of the tolerances at which they explain most.
        evidence: logarithm, against nothing added.
        foretold: logarithm of how much better runs left out are foretold, against nothing added.
    """

    scorer: Scorer
    parts: tuple[Part, ...]
    sizes: FloatArray
    level: int
    evidence: float
    foretold: float

    @property
    def columns(self) -> tuple[int, ...]:
        """Of all parts, in order."""
        return tuple(column for _, form in self.parts for column in form.columns)

    @property
    def sensible(self) -> bool:
        """Whether no component is where it makes no sense: a negative delay, a mass below zero."""
        least, most = (
            np.concatenate([np.zeros(0), *(getattr(form, end) for _, form in self.parts)])
            for end in ("least", "most")
        )
        return bool(np.all((self.sizes >= least) & (np.abs(self.sizes) <= most)))

    @cached_property
    def solution(self) -> Solution:
        """The whole fit, the baseline's columns included."""
        std = np.concatenate([np.zeros(0), *(form.std for _, form in self.parts)])
        return solve(self.scorer.products, self.scorer.levels[self.level], self.columns, std)

    def own(self, index: int) -> slice:
        """Where the components of a part stand among all parts', counted from the end."""
        counts = [len(form.columns) for _, form in self.parts]
        start = sum(counts[:index]) - sum(counts)
        stop = start + counts[index]
        return slice(start, stop if stop < 0 else None)


class Scorer:
    """Scores hypotheses on some runs.

    Args:
        levels: sums of all runs, with the baseline's priors at each level of the tolerances.
        runs: to fit.
    """

    def __init__(self, levels: Sequence[Sums], runs: Sequence[int]) -> None:
        self.levels, self.runs = tuple(levels), tuple(runs)
        self.products, self.rows = levels[0].of(runs)
        self._all = [Reduced(self.products, one) for one in levels]
        self._others = [
            [Reduced(products, one) for products in one.others(runs)] for one in levels
        ]
        self._nothing = [one.fit((), np.zeros(0)) for one in self._all]
        self.level = int(np.argmax([self._evidence(one) for one in self._nothing]))

    @cached_property
    def nothing(self) -> Solution:
        """The fit with nothing added."""
        return self.score((), foretell=False).solution

    @property
    def foretells(self) -> bool:
        """Whether there are runs enough to leave some out."""
        return bool(self._others[0])

    def _evidence(self, fit: Small) -> float:
        """Logarithm of it, but for a constant."""
        return -0.5 * self.rows * math.log(max(fit.squares, 1e-12)) - fit.log_volume

    def score(self, parts: Sequence[Part], *, foretell: bool = True) -> Scored:
        """Fit some forms together."""
        columns = [column for _, form in parts for column in form.columns]
        std = np.concatenate([np.zeros(0), *(form.std for _, form in parts)])
        fits = [one.fit(columns, std) for one in self._all]
        evidence = [self._evidence(one) for one in fits]
        level = int(np.argmax(evidence))
        gain = evidence[level] - self._evidence(self._nothing[self.level])
        cost = sum(math.log(len(hypothesis.forms)) + form.shape.spent for hypothesis, form in parts)
        foretold = self._foretold(fits[level], level, columns, std) if foretell else 0.0
        foretold -= sum(form.shape.spent for _, form in parts)
        return Scored(self, tuple(parts), fits[level].sizes, level, gain - cost, foretold)

    def _foretold(
        self, fit: Small, level: int, columns: Sequence[int], std: FloatArray
    ) -> float:
        """Log predictive density of each run under a fit of the others, against nothing added.

        Where there are few runs, of stretches of them. What one is foretold to be, with all
        uncertainty of the fit, is the evidence of all runs over that of the others.
        """
        noise = fit.squares / self.rows
        ours = self._all[level].log_evidence(fit, noise)
        usual = self._all[self.level].log_evidence(self._nothing[self.level], noise)
        total = 0.0
        for with_it, without in zip(self._others[level], self._others[self.level], strict=True):
            total += ours - with_it.log_evidence(with_it.fit(columns, std), noise)
            total -= usual - without.log_evidence(without.fit((), np.zeros(0)), noise)
        return total

    def best_form(
        self,
        hypothesis: Hypothesis,
        beside: Sequence[Part] = (),
        *,
        foreseen: bool = False,
        full: bool = True,
    ) -> Scored:
        """The form that explains most, beside others that stay.

        Args:
            foreseen: only of those that are told without having seen the signals.
            full: with what it foretells.
        """
        forms = hypothesis.foreseen if foreseen else hypothesis.forms
        scored = [self.score([*beside, (hypothesis, form)], foretell=False) for form in forms]
        best = max(
            range(len(scored)), key=lambda index: (scored[index].sensible, scored[index].evidence)
        )
        return self.score([*beside, (hypothesis, forms[best])]) if full else scored[best]
