"""How probable the recorded signals are under an explanation, on a robot within tolerance.

Residuals are  r = B b + A a + X x + e:  gains, offsets and what any recording holds (B); errors
that every robot has, a ~ N(0, level^2 tolerance^2), each family of sources at a level of its own
(A); the effects of the explanation, x ~ N(0, prior^2) (X); and e, of which each cosine coefficient
of a signal has in its band the variance

    P0 = noise + model error + (what tolerance errors add in another form than A has)^2
                             + (what the effects add in another form than X has)^2

P0 itself is known to a factor only: a band's variance P has a scaled inverse chi-squared prior of
FREEDOM degrees about P0 (Gelman et al., Bayesian Data Analysis, 3rd ed., 2013, sec. 2.6). The
evidence integrates b, a, x out (Laplace) and takes levels and P at their most probable values.

An *unmodelled term* is a hypothesis as well: a term in any signal that is smooth in time, of
unknown course and unknown size.

What is measured stands in the residuals times the gains; gains that shrink it would shrink its
noise too, and look right for that alone (errors in variables; Fuller, Measurement Error Models,
1987). What is left is therefore taken over the scale of what is measured.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.basis import make_basis
from shoecal_core.diagnosis.hypotheses import Form, Hypothesis
from shoecal_core.diagnosis.rows import Rows
from shoecal_core.diagnosis.spread import COUNTS, FORM_LEVELS, spread_of
from shoecal_core.error_sources.posterior import Posterior

Part = tuple[Hypothesis, Form]

FORM = 0.25
"""Of what an effect adds, the part that reality may have in another form."""
LEVEL, LEVEL_FREEDOM = 0.7, 3.0
"""Usual level of the tolerances, and by how many degrees of freedom it is known."""
LEAST_LEVEL, FIRST_LEVEL = 0.05, 1.5
"""The smallest level that is found, and the one at which a fit from anywhere begins."""
ROUNDS, NEXT_ROUNDS = 8, 4
"""Steps of a fit from anywhere, and of one that begins where a like one ended."""
SETTLED = 0.05
"""Logarithm of evidence by which a fit that has settled still changes."""
LEAST_SHARE = 0.02
"""Of the mean square before any fit, the least variance with which one begins."""


@dataclass(frozen=True)
class Scored:
    """Some forms together, fitted.

    Attributes:
        scorer: what scored them.
        parts: hypotheses with the form chosen of each.
        vector: (p + k,) of the baseline and of all their columns.
        evidence: logarithm, against a robot within tolerance.
        levels: (F,) of the families of tolerance errors.
        variance: (G,) of the groups. expected: (G,) what it was expected to be.
        form_level: (G,) of the forms of tolerance errors, in each signal.
        model_level: (G,) of what the model lacks in each signal.
        rest: (R,) coefficients that are left.
        unmodelled: with an unmodelled term as well.
        log_likelihood: (G,) of each group.
    """

    scorer: Scorer
    parts: tuple[Part, ...]
    vector: FloatArray
    evidence: float
    levels: FloatArray
    variance: FloatArray
    expected: FloatArray
    form_level: FloatArray
    model_level: FloatArray
    rest: FloatArray
    unmodelled: bool
    log_likelihood: FloatArray

    @property
    def columns(self) -> tuple[int, ...]:
        """Of all parts, in order."""
        return tuple(column for _, form in self.parts for column in form.columns)

    @property
    def std(self) -> FloatArray:
        """(k,) priors of their components."""
        return np.concatenate([np.zeros(0), *(form.std for _, form in self.parts)])

    @property
    def sizes(self) -> FloatArray:
        """(k,) of their components."""
        return self.vector[len(self.vector) - len(self.columns) :]

    @property
    def sensible(self) -> bool:
        """Whether no component is where it makes no sense: a negative delay, a mass below zero."""
        return all(
            sensible(form, self.sizes[self.own(at)]) for at, (_, form) in enumerate(self.parts)
        )

    @cached_property
    def weighted(self) -> _Weighted:
        """The baseline under its variances: what further hypotheses start with."""
        return self.scorer.weighted(self.variance, self.levels)

    @cached_property
    def at_nominal(self) -> Scored:
        """At nominal tolerances: as if no group were worse than expected, nor tolerance errors
        larger than usual. A fit from here tries to explain what is, while one that takes it for
        granted never would.
        """
        levels = np.minimum(self.levels, LEVEL)
        return replace(self, variance=self.expected, levels=levels)

    @cached_property
    def covariance(self) -> FloatArray:
        """(p + k, p + k) of the vector."""
        root = self.scorer.root(self)
        covariance: FloatArray = root @ root.T
        return covariance

    def own(self, index: int) -> slice:
        """Where the components of a part stand among all parts', counted from the end."""
        counts = [len(form.columns) for _, form in self.parts]
        start = sum(counts[:index]) - sum(counts)
        stop = start + counts[index]
        return slice(start, stop if stop < 0 else None)


def sensible(form: Form, sizes: FloatArray) -> bool:
    """Whether sizes (k,) of a form's components make sense."""
    return bool(np.all((sizes >= form.least) & (np.abs(sizes) <= form.most)))


@dataclass(frozen=True)
class Glance:
    """A quick look at a hypothesis.

    Attributes:
        gain: logarithm of evidence that its best form adds, one of so many.
        alike: by how much all its forms together are more probable than the best alone, as a
            logarithm: where the recording cannot tell them apart, their number costs nothing.
        parts: forms to be fitted in full.
    """

    gain: float
    alike: float
    parts: tuple[Part, ...]


@dataclass(frozen=True)
class _Weighted:
    """The baseline under some weights (G,), ready for columns to be added."""

    weight: FloatArray
    posterior: Posterior

    def eliminate(self, products: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(p, m) of m columns in terms of the baseline, and (m, m) what it leaves of them.

        Args:
            products: (p + m, m) of the baseline and of the columns with the latter, weighted.
        """
        count = len(products) - products.shape[1]
        across = self.posterior.whiten(products[:count])
        return across, products[count:] - across.T @ across


class Scorer:
    """Scores explanations on the training runs.

    Args:
        rows: what is fitted. channels: of the shoes.
        withheld: rows of the runs left out, if any are to be predicted.
        form_levels: of tolerance errors' forms, in signals that depend on the body.
    """

    def __init__(
        self,
        rows: Rows,
        channels: int,
        withheld: Rows | None = None,
        form_levels: tuple[float, ...] = FORM_LEVELS,
    ) -> None:
        self.rows, self.channels, self.withheld = rows, channels, withheld
        self.form_levels = form_levels
        self.basis = make_basis(rows, 2 * channels, withheld)
        found = self._nothing(unmodelled=False)
        self._base_evidence = found.evidence
        self.nothing = replace(found, evidence=0.0)

    @cached_property
    def unmodelled(self) -> Scored:
        """An unmodelled term, and no effect that has a name."""
        starts = (self.nothing, self.nothing.at_nominal)
        near = [self._fit((), start, ROUNDS, unmodelled=True) for start in starts]
        found = max(self._nothing(unmodelled=True), *near, key=lambda one: one.evidence)
        return replace(found, evidence=found.evidence - self._base_evidence)

    def score(
        self,
        parts: Sequence[Part],
        *,
        unmodelled: bool = False,
        start: Scored | None = None,
        rounds: int = NEXT_ROUNDS,
    ) -> Scored:
        """Fit some forms together.

        Args:
            unmodelled: with an unmodelled term as well.
            start: where variances and levels are begun with.
        """
        if not parts:
            return self.unmodelled if unmodelled else self.nothing
        start = start or (self.unmodelled if unmodelled else self.nothing)
        ways = [
            self._fit(parts, one, rounds, unmodelled=unmodelled)
            for one in (start, start.at_nominal)
        ]
        found = max(ways, key=lambda one: one.evidence)
        cost = sum(math.log(len(hypothesis.forms)) for hypothesis, _ in parts)
        return replace(found, evidence=found.evidence - self._base_evidence - cost)

    def _nothing(self, *, unmodelled: bool) -> Scored:
        rows = self.rows
        raw = rows.squares(rows.residuals) / rows.count
        variance = np.maximum(rows.noise + rows.smooth + rows.form, LEAST_SHARE * raw)
        levels = np.minimum(np.full(len(rows.most_level), FIRST_LEVEL), rows.most_level)
        return self._fit((), (variance, levels), ROUNDS, unmodelled=unmodelled)

    def weighted(self, variance: FloatArray, levels: FloatArray) -> _Weighted:
        """The baseline under variances (G,), with tolerance errors at levels (F,)."""
        each = COUNTS / variance
        posterior = Posterior(self.basis.normal(each), self.basis.prior(levels))
        return _Weighted(each, posterior)

    def _fit(
        self,
        parts: Sequence[Part],
        start: Scored | tuple[FloatArray, FloatArray],
        rounds: int,
        *,
        unmodelled: bool,
    ) -> Scored:
        """Fit at some variances and levels, take those that are most probable then, fit again.

        The two steps need not climb together, and may turn in circles: the best fit is kept, with
        its own evidence. So what contains another explanation, and starts from it, is no worse.

        Args:
            start: a fit to start with, or variances (G,) and levels (F,).
        """
        rows, basis, own_count = self.rows, self.basis, 2 * self.channels
        chosen = [column for _, form in parts for column in form.columns]
        std = np.concatenate([np.zeros(0), *(form.std for _, form in parts)])
        count = len(chosen)
        columns = rows.columns[:, chosen]
        products = basis.products(np.column_stack((columns, rows.residuals)))
        if isinstance(start, Scored):
            variance, levels, weighted = start.variance, start.levels, start.weighted
        else:
            (variance, levels), weighted = start, self.weighted(*start)
        best: Scored | None = None
        for _ in range(rounds):
            across, left = weighted.eliminate(np.tensordot(weighted.weight, products, 1))
            inner = Posterior(left[:count, :count], std**-2.0)
            sizes = inner.solve(left[:count, count])
            absorbed = weighted.posterior.unwhiten(across[:, :count] @ sizes)
            vector = weighted.posterior.unwhiten(across[:, count]) - absorbed
            added = columns @ sizes
            rest = rows.residuals - basis.columns @ vector - added
            own = rows.squares(added - basis.columns @ absorbed) / rows.count
            moved = vector[:own_count] + rows.away[:own_count]
            power = rows.squares(rest) / rows.scales(moved) ** 2
            spread = spread_of(
                rows,
                power,
                rows.smooth + FORM**2 * own,
                variance,
                self.form_levels,
                unmodelled=unmodelled,
            )
            prior = 0.5 * float((vector**2 * weighted.posterior.precision).sum())
            prior += 0.5 * float(((sizes / std) ** 2).sum())
            volume = weighted.posterior.half_log_volume + inner.half_log_volume
            likely = float(spread.log_likelihood.sum())
            found = Scored(
                self, tuple(parts), np.concatenate((vector, sizes)),
                likely - prior - volume - _level_cost(levels), levels, variance,
                spread.expected, spread.form_level, spread.model_level, rest, unmodelled,
                spread.log_likelihood,
            )  # fmt: skip
            gain = np.inf if best is None else found.evidence - best.evidence
            if gain > 0.0:
                best = found
            if abs(gain) < SETTLED:
                break
            levels = self._levels(weighted, vector)
            variance = spread.variance
            weighted = self.weighted(variance, levels)
        assert best is not None
        vector = np.concatenate((basis.whole(best.vector), best.sizes))
        return replace(best, vector=self._whole(chosen) @ vector)

    def _whole(self, chosen: Sequence[int]) -> FloatArray:
        """(p + k, p + k) that takes tolerance errors for a part of the effects that they are."""
        base = self.rows.base.shape[1]
        found = np.eye(base + len(chosen))
        for at, column in enumerate(chosen, base):
            if (same := self.rows.same[column]) >= 0:
                found[at, same], found[same, same] = 1.0, 0.0
        return found

    def _levels(self, weighted: _Weighted, vector: FloatArray) -> FloatArray:
        """(F,) most probable levels of tolerance errors, by those that the signals determine.

        The fixed point of MacKay (Neural Computation 4:415, 1992).
        """
        rows, basis = self.rows, self.basis
        posterior = weighted.posterior
        determined = 1.0 - posterior.variance * posterior.precision
        size = vector**2 * basis.precision
        found = np.empty(len(rows.most_level))
        for family, most in enumerate(rows.most_level):
            own = basis.family == family
            total = size[own].sum() + LEVEL_FREEDOM * LEVEL**2
            level = math.sqrt(total / (determined[own].sum() + LEVEL_FREEDOM))
            found[family] = min(max(level, LEAST_LEVEL), most)
        return found

    @cached_property
    def withheld_base(self) -> FloatArray:
        """(R', q) of the reduced baseline on the runs left out."""
        assert self.withheld is not None, "no runs were left out"
        return self.basis.reduced(self.withheld.base)

    def reduced_root(self, scored: Scored) -> FloatArray:
        """(q + k, q + k) square root of the covariance of the reduced unknowns and sizes."""
        return self._root(scored, self.basis.columns, self.basis.prior(scored.levels))

    def root(self, scored: Scored) -> FloatArray:
        """(p + k, p + k) square root of the covariance of a fit's vector."""
        found = self._root(scored, self.rows.base, self.rows.prior(scored.levels))
        return self._whole(scored.columns) @ found

    def _root(self, scored: Scored, base: FloatArray, precision: FloatArray) -> FloatArray:
        """The same for a baseline of these columns (R, p), with these priors (p,)."""
        weight = np.sqrt(COUNTS / scored.variance)[self.rows.group]
        whole = np.column_stack((base, self.rows.columns[:, list(scored.columns)]))
        whole *= weight[:, None]
        return Posterior(whole.T @ whole, np.concatenate((precision, scored.std**-2.0))).root

    def gains(self, hypotheses: Sequence[Hypothesis], kept: Scored | None = None) -> list[Glance]:
        """Of each hypothesis how much it explains, and the forms that explain most: a quick look.

        At the variances and levels of what is there already, and at the usual ones; forms that
        make no sense are left out.

        Args:
            kept: an explanation that stays; None: nothing.
        """
        kept = self.nothing if kept is None else kept
        lefts = [self._left(one) for one in (kept, kept.at_nominal)]
        found: list[Glance] = []
        for hypothesis in hypotheses:
            each = [one for left in lefts if (one := _glance(left, hypothesis)) is not None]
            if each:
                best = max(each, key=lambda one: one.gain)
                forms = {form.columns: (at, form) for one in each for at, form in one.parts}
                found.append(replace(best, parts=tuple(forms.values())))
        return found

    def _left(self, kept: Scored) -> FloatArray:
        """(k + 1, k + 1) products of columns and residuals, less what an explanation takes."""
        weighted, rows = kept.weighted, self.rows
        weight = np.sqrt(weighted.weight)[rows.group][:, None]
        values = np.column_stack((rows.columns, rows.residuals)) * weight
        base = self.basis.columns * weight
        _, left = weighted.eliminate(np.vstack((base.T @ values, values.T @ values)))
        if kept.parts:
            own = np.array(kept.columns, dtype=np.int64)
            taken = Posterior(left[np.ix_(own, own)], kept.std**-2.0)
            left = left - left[:, own] @ taken.solve(left[own])
        return left


def _glance(left: FloatArray, hypothesis: Hypothesis) -> Glance | None:
    """At its forms, by what the baseline leaves; None if none makes sense."""
    found = []
    for form in hypothesis.forms:
        gain, sizes = _gain(left, form)
        if sensible(form, sizes):
            found.append((gain, form))
    if not found:
        return None
    most, best = max(found, key=lambda one: one[0])
    alike = float(np.logaddexp.reduce([gain - most for gain, _ in found]))
    return Glance(most - math.log(len(hypothesis.forms)), alike, ((hypothesis, best),))


def _gain(left: FloatArray, form: Form) -> tuple[float, FloatArray]:
    """Log evidence that a form adds, and (k,) its sizes, of what the baseline leaves."""
    own = np.array(form.columns, dtype=np.int64)
    inner = Posterior(left[np.ix_(own, own)], form.std**-2.0)
    sizes = inner.solve(left[own, -1])
    return 0.5 * float(left[own, -1] @ sizes) - inner.half_log_volume, sizes


def _level_cost(levels: FloatArray) -> float:
    """Logarithm of what the priors of the levels cost."""
    ratio = levels / LEVEL
    return 0.5 * LEVEL_FREEDOM * float((2.0 * np.log(ratio) + ratio**-2.0 - 1.0).sum())
