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

import numpy as np
from numpy.typing import NDArray

from shoecal_core.diagnosis.hypotheses import Form, Hypothesis
from shoecal_core.diagnosis.regression import Solution, Sums, solve

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Scored:
    """Some forms together, fitted.

    Attributes:
        parts: hypotheses with the form chosen of each.
        solution: of the fit on all training runs.
        evidence: logarithm, against nothing added.
        foretold: logarithm of how much better runs left out are foretold, against nothing added.
    """

    parts: tuple[tuple[Hypothesis, Form], ...]
    solution: Solution
    evidence: float
    foretold: float

    @property
    def columns(self) -> tuple[int, ...]:
        """Of all parts, in order."""
        return tuple(column for _, form in self.parts for column in form.columns)

    def own(self, index: int) -> slice:
        """Where the components of a part stand in the fit's vector, counted from its end."""
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
        self._others = [sums.of([one for one in runs if one != run])[0] for run in runs]
        self.nothing = solve(self.products, sums, (), np.zeros(0))
        self._nothing_left = [solve(part, sums, (), np.zeros(0)) for part in self._others]

    def score(self, parts: Sequence[tuple[Hypothesis, Form]], *, foretell: bool = True) -> Scored:
        """Fit some forms together."""
        columns = [column for _, form in parts for column in form.columns]
        std = np.concatenate([form.std for _, form in parts]) if parts else np.zeros(0)
        solution = solve(self.products, self.sums, columns, std)
        evidence = self._evidence(solution)
        evidence -= sum(math.log(len(hypothesis.forms)) for hypothesis, _ in parts)
        foretold = 0.0
        if foretell and len(self.runs) > 2:
            foretold = self._foretold(solution, columns, std)
        return Scored(tuple(parts), solution, evidence, foretold)

    def _evidence(self, solution: Solution) -> float:
        gain = 0.5 * self.rows * math.log(self.nothing.squares / max(solution.squares, 1e-12))
        return gain - solution.log_volume

    def _foretold(self, solution: Solution, columns: Sequence[int], std: FloatArray) -> float:
        """Log predictive density of each run under a fit of the others, against nothing added.

        What a run is foretold to be, with all uncertainty of the fit, is the evidence of all
        runs over that of the others.
        """
        noise = solution.squares / self.rows
        total = 0.0
        for others, nothing in zip(self._others, self._nothing_left, strict=True):
            left = solve(others, self.sums, columns, std)
            ours = _log_evidence(solution, noise) - _log_evidence(left, noise)
            total += ours - _log_evidence(self.nothing, noise) + _log_evidence(nothing, noise)
        return total

    def best_form(
        self, hypothesis: Hypothesis, beside: Sequence[tuple[Hypothesis, Form]] = ()
    ) -> Scored:
        """The form that explains most, beside others that stay."""
        scored = [
            self.score([*beside, (hypothesis, form)], foretell=False) for form in hypothesis.forms
        ]
        best = max(range(len(scored)), key=lambda index: scored[index].evidence)
        return self.score([*beside, (hypothesis, hypothesis.forms[best])])


def _log_evidence(solution: Solution, noise: float) -> float:
    return -0.5 * solution.squares / noise - solution.log_all
