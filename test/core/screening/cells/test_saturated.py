"""Ends of cells against extremes at which force is missing for another reason."""

from __future__ import annotations

import numpy as np
import pytest

from core.screening.recordings import SETTINGS
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.blocks import BLOCK_S, Blocks
from shoecal_core.screening.cells.saturated import Saturated, saturated
from shoecal_core.shoe.wrench import ChannelParameters

COUNT, TURN = 100, 50


def found(readings: FloatArray, error: FloatArray) -> list[Saturated]:
    """Of a cell with readings (B,) [N], where the sum of forces is off by (B,) [N]."""
    time: FloatArray = BLOCK_S * np.arange(COUNT, dtype=np.float64)
    part = Blocks(
        time,
        readings[:, None],
        np.array([0.01]),
        np.zeros((COUNT, 2)),
        np.ones((1, 3)),
        np.zeros(3),
    )
    parameters = ChannelParameters(np.ones(1), np.zeros(1))
    return saturated({1: part}, {1: error}, parameters, SETTINGS)


def turning(curve: float = 0.008) -> FloatArray:
    """(B,) load of a cell that turns round at its least [N]."""
    return np.asarray(curve * (np.arange(COUNT) - TURN) ** 2)


@pytest.mark.parametrize("before", [True, False])
@pytest.mark.parametrize("after", [True, False])
def test_an_end_lets_force_be_missing_while_a_cell_is_there(before: bool, after: bool) -> None:
    """Missing before or after as well, as where gains drift, it is missing for another reason."""
    error = np.where(np.abs(np.arange(COUNT) - TURN) <= 2, 0.6, 0.0)
    error[TURN - 10 : TURN] += 0.6 * before * (error[TURN - 10 : TURN] == 0.0)
    error[TURN : TURN + 10] += 0.6 * after * (error[TURN : TURN + 10] == 0.0)
    ends = found(turning(), error)
    assert bool(ends) == (not before and not after)


def test_a_cell_that_is_at_its_end_for_long() -> None:
    load = turning()
    level = 1.0
    (end,) = found(np.maximum(load, level), np.maximum(level - load, 0.0))
    assert (end.channel, end.side) == (0, -1.0)
