"""How well a hypothesis explains what runs show, and foretells runs it was not fitted on.

With whitened residuals the logarithm of a hypothesis' evidence is
    - N/2 log(squares / N)   less   what the data narrow its components' priors
with N the number of rows: the noise is as large as what is left, so that a noise that was
guessed too small accuses nobody.
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
        log_volume: half the logarithm of how much the data narrow the columns' priors.
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
            return Small(np.zeros(0), float(self._rest[-1, -1]), 0.0)
        chosen = np.asarray(columns, dtype=np.int64)
        matrix = np.eye(len(std)) + self._rest[np.ix_(chosen, chosen)] * np.outer(std, std)
        right = std * self._rest[chosen, -1]
        factor = np.linalg.cholesky(matrix)
        half = solve_triangular(factor, right, lower=True)
        sizes = std * solve_triangular(factor.T, half, lower=False)
        squares = float(self._rest[-1, -1] - half @ half)
        return Small(sizes, squares, float(np.log(np.diag(factor)).sum()))

    def log_evidence(self, fit: Small, noise: float) -> float:
        """Of the runs under noise of this variance, but for a constant."""
        return -0.5 * fit.squares / noise - fit.log_volume - self._log_base


@dataclass(frozen=True)
class Scored:
    """Some forms together, fitted.

    Attributes:
        scorer: what scored them.
        parts: hypotheses with the form chosen of each.
        sizes: (k,) of all their columns.
        evidence: logarithm, against nothing added.
        foretold: logarithm of how much better runs left out are foretold, against nothing added.
    """

    scorer: Scorer
    parts: tuple[Part, ...]
    sizes: FloatArray
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
        return solve(self.scorer.products, self.scorer.sums, self.columns, std)

    def own(self, index: int) -> slice:
        """Where the components of a part stand among all parts', counted from the end."""
        counts = [len(form.columns) for _, form in self.parts]
        start = sum(counts[:index]) - sum(counts)
        stop = start + counts[index]
        return slice(start, stop if stop < 0 else None)


class Scorer:
    """Scores hypotheses on some runs.

    Args:
        sums: of all runs. runs: to fit.
    """

    def __init__(self, sums: Sums, runs: Sequence[int]) -> None:
        self.sums, self.runs = sums, tuple(runs)
        self.products, self.rows = sums.of(runs)
        self._all = Reduced(self.products, sums)
        self._others = [Reduced(products, sums) for products in sums.others(runs)]
        none = np.zeros(0)
        self._nothing = self._all.fit((), none)
        self._nothing_left = [others.fit((), none) for others in self._others]
        self.nothing = solve(self.products, sums, (), none)

    @property
    def foretells(self) -> bool:
        """Whether there are runs enough to leave some out."""
        return bool(self._others)

    def score(self, parts: Sequence[Part], *, foretell: bool = True) -> Scored:
        """Fit some forms together."""
        columns = [column for _, form in parts for column in form.columns]
        std = np.concatenate([np.zeros(0), *(form.std for _, form in parts)])
        fit = self._all.fit(columns, std)
        gain = 0.5 * self.rows * math.log(self._nothing.squares / max(fit.squares, 1e-12))
        cost = sum(math.log(len(hypothesis.forms)) + form.shape.spent for hypothesis, form in parts)
        foretold = self._foretold(fit, columns, std) if foretell else 0.0
        foretold -= sum(form.shape.spent for _, form in parts)
        return Scored(self, tuple(parts), fit.sizes, gain - fit.log_volume - cost, foretold)

    def _foretold(self, fit: Small, columns: Sequence[int], std: FloatArray) -> float:
        """Log predictive density of each run under a fit of the others, against nothing added.

        Where there are few runs, of stretches of them. What one is foretold to be, with all
        uncertainty of the fit, is the evidence of all runs over that of the others.
        """
        noise = fit.squares / self.rows
        ours, usual = (self._all.log_evidence(one, noise) for one in (fit, self._nothing))
        total = 0.0
        for others, nothing in zip(self._others, self._nothing_left, strict=True):
            left = others.fit(columns, std)
            total += ours - others.log_evidence(left, noise)
            total -= usual - others.log_evidence(nothing, noise)
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
