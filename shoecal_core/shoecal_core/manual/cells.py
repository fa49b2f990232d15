"""Single cells under known weights (paper, section III-A and eq. 3).

A cell off its shoe reads S = S_0 + sigma G under a load G [N]. Of two loads sigma is
(S_G - S_0) / G, of more the slope of the least-squares line; F = a S + b then has a = 1 / sigma and
b = -S_0 / sigma.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.manual.loads import require_cells
from shoecal_core.manual.measurements import Measurements, stacked
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe.shoe import Shoe

LEAST_RESPONSE = 1e-4
"""A cell whose reading changes by less than this part of the converter's range is dead."""


@dataclass(frozen=True)
class CellFit:
    """One cell's affine law.

    Attributes:
        name: of the channel.
        gain: a [N/unit].
        offset: b [N].
        covariance: (2, 2) of (gain, offset); NaN where the readings' scatter is not known.
        masses: (L,) [kg].
        readings: (L,) means [unit].
        residuals: (L,) force by this law minus the weight [N].
    """

    name: str
    gain: float
    offset: float
    covariance: FloatArray
    masses: FloatArray
    readings: FloatArray
    residuals: FloatArray

    @property
    def residual_std(self) -> float:
        """Scatter about the line [N]; NaN for two loads, which lie on it."""
        free = len(self.masses) - 2
        return float(np.sqrt((self.residuals**2).sum() / free)) if free else float("nan")


def fit_cells(cells: Measurements) -> tuple[CellFit, ...]:
    """The law of every cell of the shoe, in the shoe's order.

    Raises:
        FileError: for a shoe with other sensors than load cells.
        ShoecalError: for cells that were not read with and without a weight, that did not
            respond, or in whose place another one did.
    """
    shoe = cells.shoe
    require_cells(shoe)
    missing = [name for name in shoe.names if not cells.of_cell(name)]
    if missing:
        raise cells.error(f"no readings of {', '.join(missing)}; read every cell by itself")
    return tuple(_fit(cells, name) for name in shoe.names)


def _fit(cells: Measurements, name: str) -> CellFit:
    shoe = cells.shoe
    masses, means, noises = stacked(cells.of_cell(name))
    if len(np.unique(masses)) < 2:
        raise cells.error(
            f"{name} was read under {masses[0]:g} kg only; read it without and with a weight"
        )
    if problem := wrong_response(cells, name):
        raise cells.error(problem)
    channel = shoe.index(name)
    own = shoe.of_foot(int(shoe.foot[channel])).tolist().index(channel)
    readings, noise = means[:, own], noises[:, own]
    weights = masses * GRAVITY
    design = np.stack((np.ones_like(weights), weights), axis=1)
    (zero, slope), *_ = np.linalg.lstsq(design, readings, rcond=None)
    gain, offset = 1.0 / slope, -zero / slope
    # Of a = 1 / sigma and b = -S_0 / sigma by (S_0, sigma).
    jacobian = np.array([[0.0, -(gain**2)], [-gain, zero * gain**2]])
    left = readings - design @ (zero, slope)
    spread = jacobian @ _covariance(design, left, noise) @ jacobian.T
    return CellFit(
        name=name,
        gain=float(gain),
        offset=float(offset),
        covariance=spread,
        masses=masses,
        readings=readings,
        residuals=gain * readings + offset - weights,
    )


def _covariance(design: FloatArray, left: FloatArray, noise: FloatArray) -> FloatArray:
    """(2, 2) of (S_0, sigma): by the larger of recorded noise and found scatter."""
    recorded = float((noise**2).mean())
    free = len(left) - 2
    found = float(left @ left) / free if free else np.nan
    # fmax: the one that is known where the other is not.
    variance = np.fmax(recorded, found)
    covariance: FloatArray = variance * np.linalg.inv(design.T @ design)
    return covariance


def wrong_response(cells: Measurements, name: str) -> str:
    """What is wrong with how the cells answered to weights on one of them; empty: nothing."""
    shoe = cells.shoe
    masses, means, _ = stacked(cells.of_cell(name))
    channels = shoe.of_foot(int(shoe.foot[shoe.index(name)]))
    span = np.array(
        [shoe.channels[index].highest - shoe.channels[index].lowest for index in channels]
    )
    known = np.isfinite(means).all(axis=0)
    changes = np.where(known, np.ptp(np.where(known, means, 0.0), axis=0) / span, 0.0)
    most = shoe.names[channels[int(np.argmax(changes))]]
    if changes.max() < LEAST_RESPONSE:
        return f"{name} does not respond to {masses.max():g} kg; check its wiring"
    if most != name:
        return (
            f"{most} responded to the weight on {name}; load {name} again, or correct the "
            "driver's channels"
        )
    return ""


def law(fits: tuple[CellFit, ...]) -> tuple[FloatArray, FloatArray, FloatArray | None]:
    """Gains (n,), offsets (n,) and covariance (2n, 2n) of [gain, offset], None where unknown."""
    count = len(fits)
    covariance = np.zeros((2 * count, 2 * count))
    for index, fit in enumerate(fits):
        both = [index, count + index]
        covariance[np.ix_(both, both)] = fit.covariance
    return (
        np.array([fit.gain for fit in fits]),
        np.array([fit.offset for fit in fits]),
        covariance if np.isfinite(covariance).all() else None,
    )


def unlike_gains(shoe: Shoe, gain: FloatArray, ratio: float) -> list[tuple[str, float, float]]:
    """Cells whose gain is not within a ratio of the typical one: name, gain, typical size.

    Args:
        shoe: with n cells.
        gain: (n,) [N/unit].
        ratio: to the median of their sizes.
    """
    typical = float(np.median(np.abs(gain)))
    return [
        (name, float(value), typical)
        for name, value in zip(shoe.names, gain, strict=True)
        if not typical / ratio < abs(value) < typical * ratio
    ]
