"""Where the expected error of the CoP comes from, and what would shrink it most.

Of a linear Gaussian estimate with priors P, posterior C and data, the error is
    estimate - truth = noise term - C P^-1 (truth - prior mean),
so that of the variance J C J' of an output with derivatives J the unknown i has the part
(J C e_i)^2 / P_ii, and noise and form error have the rest. What a source has in the error of this
very calibration follows from what is believed of it now: draws of the posterior. What would be won
by knowing a set of unknowns exactly follows from the conditional covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.estimation.joint_fit import JointFit
from shoecal_core.estimation.uncertainty.expected import ErrorModel, Spread

DRAWS = 400
ROUNDING = 1e-12
"""Added to a covariance in units of its priors, which rounding may leave indefinite."""
CREDIBLE = 0.95
NOISE, PRIOR, SIDEWAYS, SUPPORT = "noise", "gains_and_offsets", "sideways_force", "support"
"""Sources that are no deviations: noise with form error, what only the prior of gains and offsets
fixes, sideways forces at the cells' height, and where the right foot stands."""


@dataclass(frozen=True)
class ErrorSource:
    """One kind of error source; arrays are for both feet, left, right.

    Attributes:
        effect: identifier, or one of the names above.
        size: (3,) root mean square CoP error that it causes, over the sensing polygons [m].
        share: (3,) of the mean square error.
        interval: (3, 2) 95 % interval of that share in this calibration.
        without: (3,) expected CoP error if it were known exactly [m]; NaN where it cannot be.
    """

    effect: str
    size: FloatArray
    share: FloatArray
    interval: FloatArray
    without: FloatArray


@dataclass(frozen=True)
class Budget:
    """The CoP error's sources, the largest first; arrays are for both feet, left, right.

    Attributes:
        total: (3,) root mean square CoP error over the sensing polygons [m].
        sources: whose mean squares add up to the total's.
    """

    total: FloatArray
    sources: tuple[ErrorSource, ...]

    def source(self, effect: str) -> ErrorSource | None:
        """That of one name; None where it has no part."""
        return next((one for one in self.sources if one.effect == effect), None)

    def to_json(self) -> list[dict[str, object]]:
        """Rows for result files, shares of the error of both feet [mm]."""
        return [
            {
                "source": one.effect,
                "cop_share": float(one.share[0]),
                "ci95": one.interval[0].tolist(),
                "cop_mm": (1e3 * one.size).tolist(),
                "cop_mm_if_known": [
                    None if np.isnan(value) else 1e3 * float(value) for value in one.without
                ],
            }
            for one in self.sources
        ]


def budget(fit: JointFit, model: ErrorModel, spreads: Sequence[Spread]) -> Budget:
    """The budget of a calibration's expected CoP error.

    Args:
        fit: of the calibration.
        model: its expected errors.
        spreads: of both feet, left and right over the sensing polygons.
    """
    total = np.array([_mean_square(one) for one in spreads])
    jacobians = _jacobians(fit, model)
    groups = unknowns(fit)
    parts = mean_squares(fit, model, _draws(fit))  # (3, g + 1, draws)
    estimated = np.array([_variance(one, fit.covariance) for one in jacobians])
    extra = np.clip(total - estimated, 0.0, None)
    names = [*groups, NOISE]
    squares = np.array([_expected(fit, one, groups) for one in jacobians])  # (3, g + 1)
    drawn_total = parts.sum(axis=1) + extra[:, None]
    sources = []
    for index, name in enumerate(names):
        known = np.full(3, np.nan)
        if name in groups and name != PRIOR:
            rest = _conditional(fit.covariance, groups[name])
            known = np.sqrt(np.array([_variance(one, rest) for one in jacobians]) + extra)
        shares = parts[:, index] / drawn_total
        sources.append(_source(name, squares[:, index], total, shares, known))
    for name, square in ((SUPPORT, extra * [1, 0, 0]), (SIDEWAYS, extra * [0, 1, 1])):
        shares = square[:, None] / drawn_total
        sources.append(_source(name, square, total, shares, np.sqrt(total - square)))
    sources.sort(key=lambda one: float(one.share.sum()), reverse=True)
    return Budget(np.sqrt(total), tuple(one for one in sources if one.share.any()))


def _source(
    name: str, square: FloatArray, total: FloatArray, shares: FloatArray, known: FloatArray
) -> ErrorSource:
    interval = np.array([_credible(drawn) for drawn in shares])
    return ErrorSource(name, np.sqrt(square), square / total, interval, known)


def _credible(shares: FloatArray) -> FloatArray:
    """(2,) the shortest interval that holds most of the draws.

    A share cannot be negative: one that may well be nothing has an interval from zero on, which
    one between two quantiles would leave out.
    """
    ordered = np.concatenate(([min(0.0, shares.min())], np.sort(shares)))
    held = int(np.ceil(CREDIBLE * len(shares)))
    first = int(np.argmin(ordered[held:] - ordered[:-held]))
    return ordered[[first, first + held]]


def unknowns(fit: JointFit) -> dict[str, IntArray]:
    """(k,) indices of the unknowns of each kind of source."""
    first = len(fit.vector)
    found: dict[str, list[int]] = {PRIOR: list(range(first - 1)), "time_offset": [first - 1]}
    for index, one in enumerate(fit.deviations, start=first):
        name = "placement" if one.deviation.effect == SUPPORT else one.deviation.effect
        found.setdefault(name, []).append(index)
    return {name: np.array(indices) for name, indices in found.items()}


def mean_squares(fit: JointFit, model: ErrorModel, wrong: FloatArray) -> FloatArray:
    """(3, g + 1, d) mean square CoP errors by the g kinds of `unknowns`, then by noise [m^2].

    Args:
        fit, model: as `budget` takes them.
        wrong: (u, d) errors of all unknowns, estimate less truth.
    """
    groups = unknowns(fit)
    return np.array([_parts(fit, one, groups, wrong) for one in _jacobians(fit, model)])


def _jacobians(fit: JointFit, model: ErrorModel) -> list[FloatArray]:
    """(2 p, u) of the CoP of both feet, left and right, by all unknowns."""
    both, left, right = model.load_cases()
    return [
        _of_all(fit, model.both_jacobian(both, model.robot.neutral)[:, 1:]),
        _of_all(fit, model.foot_jacobian(left, 0)[:, 1:]),
        _of_all(fit, model.foot_jacobian(right, 1)[:, 1:]),
    ]


def _of_all(fit: JointFit, jacobian: FloatArray) -> FloatArray:
    """(2 p, u) derivatives by all unknowns, of those (p, 2, 2n + d) by what measures."""
    count = len(fit.vector) - 1
    whole = np.zeros((2 * len(jacobian), len(fit.covariance)))
    flat = jacobian.reshape(len(whole), -1)
    whole[:, :count] = flat[:, :count]
    measuring = [
        index
        for index, one in enumerate(fit.deviations, start=count + 1)
        if one.deviation.shoe_column is not None
    ]
    whole[:, measuring] = flat[:, count:]
    return whole


def _variance(jacobian: FloatArray, covariance: FloatArray) -> float:
    """Mean over p places of the variances along x and y [m^2]."""
    return 2.0 * float(np.mean(np.sum((jacobian @ covariance) * jacobian, axis=1)))


def _mean_square(spread: Spread) -> float:
    return float(np.nanmean(np.sum(spread.cop**2, axis=1)))


def _gains(fit: JointFit, jacobian: FloatArray) -> FloatArray:
    """(2 p, u) what one unit of each unknown's true value adds to the error, but for its sign."""
    gains: FloatArray = (jacobian @ fit.covariance) / fit.prior_std**2
    return gains


def _expected(fit: JointFit, jacobian: FloatArray, groups: dict[str, IntArray]) -> FloatArray:
    """(g + 1,) mean squares of the groups and of noise, before anything was recorded."""
    by = 2.0 * np.mean((_gains(fit, jacobian) * fit.prior_std) ** 2, axis=0)
    parts = [float(by[indices].sum()) for indices in groups.values()]
    return np.array([*parts, max(_variance(jacobian, fit.covariance) - sum(parts), 0.0)])


def _draws(fit: JointFit) -> FloatArray:
    """(u, draws) errors of all unknowns, drawn from the posterior."""
    scaled = fit.covariance / np.outer(fit.prior_std, fit.prior_std)
    root = np.linalg.cholesky(scaled + ROUNDING * np.eye(len(scaled)))
    drawn = np.random.default_rng(0).standard_normal((len(scaled), DRAWS))
    wrong: FloatArray = fit.prior_std[:, None] * (root @ drawn)
    return wrong


def _parts(
    fit: JointFit, jacobian: FloatArray, groups: dict[str, IntArray], wrong: FloatArray
) -> FloatArray:
    """(g + 1, d) mean squares of the groups and of noise, for errors (u, d)."""
    estimate = np.concatenate((fit.away, [one.value for one in fit.deviations]))
    truth = estimate[:, None] - wrong
    gains = _gains(fit, jacobian)
    parts = [-gains[:, indices] @ truth[indices] for indices in groups.values()]
    parts.append(jacobian @ wrong - sum(parts))
    return np.array([2.0 * np.mean(one**2, axis=0) for one in parts])


def _conditional(covariance: FloatArray, known: IntArray) -> FloatArray:
    """Covariance of all unknowns once some are known exactly."""
    own = covariance[np.ix_(known, known)]
    across = covariance[:, known]
    rest: FloatArray = covariance - across @ np.linalg.pinv(own, hermitian=True) @ across.T
    return rest
