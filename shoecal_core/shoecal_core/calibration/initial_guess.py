"""The first guess of gains and offsets: one law for all channels of a kind.

Paper, eqs. 16 and 17: the CoP rows are c G = sum (c0 S_i + d0) t_i, about the left sole's
origin; the weight row is G = sum (c0 S_i + d0). Channels wired with opposite signs enter with
their polarity.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.stance import Stance
from shoecal_core.errors import ShoecalError
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters

FloatArray = NDArray[np.float64]


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
    polarity: NDArray[np.int64]
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
    rows, targets = [], []
    for stance in stances:
        target = stance.reference - stance.base - (stance.readings * gain) @ stance.columns
        signed = stance.readings[:, common] * polarity[common]
        columns = stance.columns[common]
        wanted = (0, 1, 2) if weight_row else (1, 2)
        for axis in wanted:
            slope = signed @ columns[:, axis]
            rows.append(np.stack((slope, np.full_like(slope, columns[:, axis].sum())), axis=1))
            targets.append(target[:, axis])
    matrix, target = np.concatenate(rows), np.concatenate(targets)
    scale = np.linalg.norm(matrix, axis=0)
    if not (scale > 0).all():
        raise ShoecalError("the readings do not change the force: check that the cells are alive")
    solution, _, rank, _ = np.linalg.lstsq(matrix / scale, target, rcond=1e-9)
    if rank < 2:
        raise ShoecalError(
            "the readings stay constant, so gain and offset cannot be told apart: "
            "record runs in which the robot moves"
        )
    c0, d0 = solution / scale
    gain[common] = c0 * polarity[common]
    offset[common] = d0
    return InitialGuess(ChannelParameters(gain, offset), polarity, float(c0), float(d0))


def _polarity(stances: Sequence[Stance]) -> NDArray[np.int64]:
    """Signs of the gains from the data alone.

    The same rows with one gain and one offset a channel are linear; what the data leave open
    is held small by a ridge, and only the signs are used.
    """
    count = 2 * len(stances[0].columns)
    total, right = np.zeros((count, count)), np.zeros(count)
    for stance in stances:
        target = stance.reference - stance.base
        for axis in (0, 1, 2):
            column = stance.columns[:, axis]
            offsets = np.broadcast_to(column, stance.readings.shape)
            scale = 1.0 if axis == 0 else 20.0  # a force at 5 cm counts as the force itself
            rows = scale * np.hstack((stance.readings * column, offsets))
            total += rows.T @ rows
            right += scale * (rows.T @ target[:, axis])
    size = np.sqrt(np.diag(total))
    size[size == 0.0] = 1.0
    ridge = 1e-4 * np.eye(count)
    gains = np.linalg.solve(total / np.outer(size, size) + ridge, right / size)[: count // 2]
    return np.where(gains < 0.0, -1, 1)
