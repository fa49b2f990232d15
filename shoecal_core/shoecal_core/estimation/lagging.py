"""Cells that follow the load late, each for itself.

A cell that settles with the time constant tau reads y where the load is x = y + tau dy/dt (a worn
mount, a wet cable, a filter left in a converter). The whole fit bends around it: gains come out
halved while force and CoP still agree, on test runs of the same cell too. So the fit is compared,
for each cell alone, with the fit in which it may lag: one Gauss-Newton step from the minimum, with
one more column c_i dr/df_i dS_i/dt. It lags if that saves enough of the cost.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.least_squares import Prior
from shoecal_core.estimation.residuals import ResidualWeights, residuals, unpack
from shoecal_core.samples.filters import evenly
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe

SMOOTHING_S = 0.3
"""Readings are smoothed so long before they are differentiated: noise is not change."""
PRIOR_S = 4.0
"""Cells settle within some seconds; a longer lag is drift."""
MIN_SAMPLES = 20
LEAST_LAG_S = 0.1
"""Shorter ones shift the CoP of slow motions by less than calibrating leaves."""
LEAST_SAVED = 16.0
"""Of the cost: four standard deviations."""
LEAST_SHARE = 0.25
"""Of the cost: what is left is then more this cell's lag than what every model lacks."""


@dataclass(frozen=True)
class Lag:
    """What one cell's readings say of its own time constant.

    Attributes:
        channel: index of the cell.
        seconds: time constant, with its standard deviation `std` [s].
        std: as the fit sees it [s].
        saved: of the fit's cost, in squared standard deviations.
        share: the same, of the whole cost.
    """

    channel: int
    seconds: float
    std: float
    saved: float
    share: float

    @property
    def found(self) -> bool:
        """Whether the cell lags, beyond what noise and model leave open."""
        large = self.seconds >= LEAST_LAG_S and self.saved >= LEAST_SAVED
        return large and self.share >= LEAST_SHARE


def lags(
    vector: FloatArray, prior: Prior, stances: Sequence[Stance], weights: ResidualWeights
) -> tuple[Lag, ...]:
    """The lag of every cell, each as if it alone had one.

    Args:
        vector: minimum of the fit, (2n + 1,).
        prior: of that fit.
        stances: it was fitted to; those in double support are looked at.
        weights: of its residuals.
    """
    parameters, _ = unpack(vector)
    size, channels = len(vector), len(parameters.gain)
    gradient, cost = np.zeros(size + channels), 0.0
    hessian = np.zeros((size + channels,) * 2)
    for stance in stances:
        if stance.hanging is not None or len(stance.time) < MIN_SAMPLES:
            continue
        share = weights.of_sample(stance)
        error, jacobian = residuals(vector, stance, weights)
        # By the offset, that is by the output; (3, T, n).
        slopes = jacobian[:, channels : 2 * channels].reshape(3, -1, channels)
        late = (slopes * (parameters.gain * _rates(stance))).reshape(-1, channels)
        extended = np.hstack((jacobian, late))
        hessian += share * extended.T @ extended
        gradient += share * extended.T @ error
        cost += share * float(error @ error)
    gradient[:size] += (vector - prior.mean) / prior.std**2
    hessian[np.diag_indices_from(hessian)] += np.concatenate(
        (prior.std**-2.0, np.full(channels, PRIOR_S**-2.0))
    )
    fitted = list(range(size))
    before = _saved(hessian, gradient, fitted)
    found = []
    for channel in range(channels):
        among = [*fitted, size + channel]
        covariance = np.linalg.inv(hessian[np.ix_(among, among)])
        saved = _saved(hessian, gradient, among) - before
        step = -covariance @ gradient[among]
        # The column holds the bent gain; with the step it is the straight one.
        gain = parameters.gain[channel]
        bent = gain / (gain + step[channel])
        found.append(
            Lag(
                channel=channel,
                seconds=float(bent * step[-1]),
                std=float(abs(bent) * np.sqrt(covariance[-1, -1])),
                saved=saved,
                share=saved / cost if cost > 0.0 else 0.0,
            )
        )
    return tuple(found)


def check_lags(shoe: Shoe, found: Sequence[Lag]) -> list[Finding]:
    """A calibration that a lagging cell has bent; the cell that explains most of it."""
    worst = max((lag for lag in found if lag.found), key=lambda lag: lag.saved, default=None)
    if worst is None:
        return []
    return [
        Finding(
            "FAIL",
            f"{shoe.names[worst.channel]} follows its load late, by {worst.seconds:.2f} s "
            f"(give or take {worst.std:.2f} s), which bends all gains: look for what rubs or "
            "sticks at its mount, for water, and for a filter in its converter; replace it",
            Fault.SLOW,
        )
    ]


def _rates(stance: Stance) -> FloatArray:
    """(T, n) rate of change of the readings [1/s]."""

    def rates(even: FloatArray, step: float) -> FloatArray:
        smooth = gaussian_filter1d(even, SMOOTHING_S / step, axis=0, mode="nearest")
        return np.asarray(np.gradient(smooth, step, axis=0))

    return evenly(rates, stance.readings, stance.time)


def _saved(hessian: FloatArray, gradient: FloatArray, among: list[int]) -> float:
    """What a Gauss-Newton step in some of the parameters saves of the cost."""
    part = gradient[among]
    return float(part @ np.linalg.solve(hessian[np.ix_(among, among)], part))
