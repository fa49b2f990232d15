"""The first guess of gains and offsets: one law for all channels of a kind.

Paper, eqs. 16 and 17: the CoP rows are c G = sum (c0 S_i + d0) t_i, about the left sole's
origin; the weight row is G = sum (c0 S_i + d0). Channels wired with opposite signs enter with
their polarity.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.chunks import chunks
from shoecal_core.samples.stance import Stance
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, by_parameters


@dataclass(frozen=True)
class InitialGuess:
    """The guess, and the common law behind it.

    Attributes:
        parameters: of every channel.
        polarity: (n,) sign of each channel's gain, known or found.
        gain, offset: the common c0 (of a positive channel) and d0; NaN where all channels
            have a data-sheet gain.
    """

    parameters: ChannelParameters
    polarity: IntArray
    gain: float
    offset: float


def initial_guess(shoe: Shoe, stances: Sequence[Stance], *, weight_row: bool) -> InitialGuess:
    """Least squares over all samples of all stances.

    Args:
        weight_row: also ask for the weight, not only for the CoP (the paper asks only for
            the CoP).

    Raises:
        ShoecalError: when the samples do not fix the two numbers.
    """
    if not stances:
        raise ShoecalError("no samples to guess from: give at least one training run")
    polarity = shoe.polarity
    if (polarity == 0).any():
        polarity = np.where(polarity != 0, polarity, _polarity(stances))
    nominal = np.array(
        [np.nan if c.nominal_gain is None else abs(c.nominal_gain) for c in shoe.channels]
    )
    known = np.isfinite(nominal)
    gain: FloatArray = np.where(known, polarity * nominal, 0.0)
    offset = np.zeros(len(polarity))
    common = ~known
    if not common.any():
        return InitialGuess(ChannelParameters(gain, offset), polarity, np.nan, np.nan)
    triangle = np.zeros((0, 3))
    for stance in stances:
        columns = np.where(common[:, None], stance.columns, 0.0)
        for readings, expected in _samples(stance):
            target = expected - (readings * gain) @ stance.columns
            slope = (readings * polarity) @ columns
            ones = np.broadcast_to(columns.sum(axis=0), slope.shape)
            rows = np.stack((slope, ones, target), axis=2)[:, 0 if weight_row else 1 :]
            # The triangle of a QR decomposition says all that the rows before it said.
            rows = np.concatenate((triangle, rows.reshape(-1, 3)))
            triangle = np.asarray(np.linalg.qr(rows, mode="r"))
    c0, d0 = _common_law(triangle[:, :2], triangle[:, 2])
    gain[common] = c0 * polarity[common]
    offset[common] = d0
    return InitialGuess(ChannelParameters(gain, offset), polarity, c0, d0)


def _samples(stance: Stance) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Chunks of readings (m, n) and of the wrench (m, 3) that the channels should make."""
    for part in chunks(len(stance.time)):
        yield stance.readings[part], at_cop(stance.force[part], stance.cop[part]) - stance.base


def _common_law(matrix: FloatArray, target: FloatArray) -> tuple[float, float]:
    """c0 and d0 by least squares of rows (k, 2) to a target (k,)."""
    scale = np.linalg.norm(matrix, axis=0)
    if not (scale > 0).all():
        raise ShoecalError("the readings do not change the force: check that the cells are alive")
    solution, _, rank, _ = np.linalg.lstsq(matrix / scale, target, rcond=1e-9)
    if rank < 2:
        raise ShoecalError(
            "the readings stay constant, so gain and offset are not identifiable: "
            "record runs in which the robot moves"
        )
    c0, d0 = solution / scale
    return float(c0), float(d0)


def _polarity(stances: Sequence[Stance]) -> IntArray:
    """Signs of the gains from the data alone.

    The same rows with one gain and one offset a channel are linear; what the data leave open
    is held small by a ridge, and only the signs are used. Offsets are taken at the mean readings:
    converters need not be centred.
    """
    samples = sum(len(stance.readings) for stance in stances)
    middle = sum(stance.readings.sum(axis=0) for stance in stances) / max(samples, 1)
    count = 2 * len(stances[0].columns)
    total, right = np.zeros((count, count)), np.zeros(count)
    scale = np.array([1.0, 20.0, 20.0])  # a force at 5 cm counts as the force itself
    for stance in stances:
        for readings, expected in _samples(stance):
            rows = by_parameters(scale[:, None] * stance.columns.T, readings - middle)
            flat = rows.reshape(-1, count)
            total += flat.T @ flat
            right += flat.T @ (scale * expected).ravel()
    size = np.sqrt(np.diag(total))
    size[size == 0.0] = 1.0
    ridge = 1e-4 * np.eye(count)
    gains = np.linalg.solve(total / np.outer(size, size) + ridge, right / size)[: count // 2]
    return np.where(gains < 0.0, -1, 1)
