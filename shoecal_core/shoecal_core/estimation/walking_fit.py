"""Gains and offsets from a walk.

What the model of a walk misses recurs in every step, and in every trial. Samples that err alike are
not many, however many there are: all stances of a kind (left foot alone, right foot alone, both)
together count as one, and a residual counts by no less than residuals are large. So gains that a
walk shows poorly stay at their data sheets, whatever the number of trials.

Offsets come from the feet in the air: each run's zeros are taken off its readings before the fit,
which leaves the offsets as uncertain as zeros are.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.least_squares import Fit, Prior, minimise
from shoecal_core.estimation.residuals import ResidualWeights, errors, rows_of
from shoecal_core.samples.stance import Stance
from shoecal_core.samples.zeros import Zero
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET, Shoe

LEAST_ALONE_S = 2.0
"""On each foot of a walk."""
REWEIGHED = 3
"""Times that the size of residuals is looked at."""


@dataclass(frozen=True)
class CommonZeros:
    """The zeros that a walk's stances are brought to.

    Attributes:
        reading: (n,) of each channel, the mean of the runs; 0 where no run shows its foot's.
        std: (n,) its standard deviation; NaN where no run shows it.
    """

    reading: FloatArray
    std: FloatArray


def common_zeros(shoe: Shoe, zeros: Sequence[Zero], runs: Sequence[int]) -> CommonZeros:
    """Mean zeros of some runs."""
    reading, std = np.zeros(len(shoe.names)), np.full(len(shoe.names), np.nan)
    for foot in range(len(FEET)):
        own = [zero for zero in zeros if zero.foot == foot and zero.run in runs]
        if own:
            mine = shoe.of_foot(foot)
            reading[mine] = np.mean([zero.reading[mine] for zero in own], axis=0)
            std[mine] = np.sqrt(np.mean([zero.reading_std[mine] ** 2 for zero in own], axis=0))
    return CommonZeros(reading, std)


def at_common_zeros(
    shoe: Shoe, stances: Sequence[Stance], zeros: Sequence[Zero], common: CommonZeros
) -> list[Stance]:
    """Stances with readings as if every run had the common zeros; a foot without keeps its own."""
    shift = zero_shifts(shoe, zeros, common)
    return [
        replace(stance, readings=stance.readings + shift[stance.run])
        if stance.run in shift
        else stance
        for stance in stances
    ]


def zero_shifts(shoe: Shoe, zeros: Sequence[Zero], common: CommonZeros) -> dict[int, FloatArray]:
    """(n,) by run, what raw readings change by where the run gets the common zeros."""
    shift: dict[int, FloatArray] = {}
    for zero in zeros:
        own = (shoe.foot == zero.foot) & np.isfinite(common.std)
        change = np.where(own, common.reading - zero.reading, 0.0)
        shift[zero.run] = shift.get(zero.run, np.zeros(len(own))) + change
    return shift


def fit_walk(
    shoe: Shoe,
    stances: Sequence[Stance],
    prior: Prior,
    common: CommonZeros,
    settings: CalibrationSettings,
) -> Fit:
    """Gains, offsets and time offset.

    Args:
        shoe: of n channels.
        stances: at the common zeros.
        prior: of gains, offsets and time offset, as without zeros.
        common: their zeros.
        settings: least sizes of the residuals.
    """
    count = len(shoe.names)
    centred = [replace(one, readings=one.readings - common.reading) for one in stances]
    known = np.isfinite(common.std)
    mean, std = prior.mean.copy(), prior.std.copy()
    offsets = slice(count, 2 * count)
    mean[offsets][known] = 0.0
    std[offsets][known] = (np.abs(mean[:count]) * common.std)[known]
    kinds = Counter(stance.loaded for stance in centred if len(stance.time))
    shares = [1.0 / max(1, kinds[stance.loaded]) for stance in centred]
    weights = ResidualWeights.of(settings)
    for _ in range(REWEIGHED):
        rows = rows_of(centred, shoe, weights, shares)
        fit = minimise(rows, Prior(mean, std))
        weights = _as_large(fit.vector, centred, settings)
    return _uncentred(fit, common.reading)


def _as_large(
    vector: FloatArray, stances: Sequence[Stance], settings: CalibrationSettings
) -> ResidualWeights:
    """Weights of residuals that are as large as they turned out, and no smaller than set."""
    unit = ResidualWeights(1.0, 1.0, settings.correlation_s)
    rows = [errors(vector, stance, unit).reshape(3, -1) for stance in stances]
    size = np.sqrt(np.mean(np.concatenate(rows, axis=1) ** 2, axis=1))
    return ResidualWeights(
        max(settings.force_std_n, float(size[0])),
        max(settings.cop_std_m, float(np.sqrt(np.mean(size[1:] ** 2)))),
        settings.correlation_s,
    )


def _uncentred(fit: Fit, zeros: FloatArray) -> Fit:
    """The fit of readings as they are: offsets are those of centred ones less gain times zero."""
    count = len(zeros)
    turn = np.eye(len(fit.vector))
    turn[count : 2 * count, :count] = -np.diag(zeros)
    back = np.linalg.inv(turn)
    return replace(
        fit,
        vector=turn @ fit.vector,
        covariance=turn @ fit.covariance @ turn.T,
        information=back.T @ fit.information @ back,
        directions=fit.directions @ turn.T,
    )


def check_stances(stances: Sequence[Stance]) -> list[Finding]:
    """A walk that shows too little of a foot alone: what was found, and what is needed."""
    if not walks(stances) or all(_seconds(stances, foot) >= LEAST_ALONE_S for foot in (0, 1)):
        return []
    return [
        Finding(
            "WARN",
            f"{stances_found(stances)}; at least {LEAST_ALONE_S:g} s on each foot alone are "
            "needed for its gains and zeros: walk more slowly, or step on the spot",
        )
    ]


def stances_found(stances: Sequence[Stance]) -> str:
    """How long the robot stood on flat, still feet."""
    each = ", ".join(
        f"{_seconds(stances, foot):.1f} s on the {name} foot alone"
        for foot, name in enumerate(FEET)
    )
    return f"the runs stand flat and still for {_seconds(stances, None):.1f} s on both feet, {each}"


def _seconds(stances: Sequence[Stance], alone: int | None) -> float:
    hanging = None if alone is None else 1 - alone
    return sum(one.duration for one in stances if one.hanging == hanging)


def walks(stances: Sequence[Stance]) -> bool:
    """Whether any of them is of a robot that moves fast."""
    return any(not stance.quasi_static for stance in stances)
