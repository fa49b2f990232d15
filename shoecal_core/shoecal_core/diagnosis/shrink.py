"""How far the gap shrinks on runs that no fit has seen."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.diagnosis.result import Gap, Shrink
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import COP, GRF

MEAN_NORM = float(np.sqrt(np.pi / 2.0))
"""Mean length of two normal numbers of unit deviation."""
MEAN_SIZE = float(np.sqrt(2.0 / np.pi))
"""Mean size of one."""
DRAWS = 400
"""Of the bootstrap."""
FORCE_AND_PLACE = slice(GRF.start, COP.stop)


def gap(workspace: Workspace, rest: FloatArray) -> Gap:
    """Errors against the model on the test runs [mm, N], of residuals (T, s), and their floor."""
    cop, grf = maes(workspace, rest, judged_runs(workspace))
    noise = workspace.floor
    return Gap(
        cop_mae_mm=1e3 * cop,
        grf_mae_n=grf,
        cop_floor_mm=1e3 * MEAN_NORM * float(np.sqrt((noise[COP] ** 2).mean())),
        grf_floor_n=MEAN_SIZE * float(noise[0]),
    )


def maes(workspace: Workspace, rest: FloatArray, runs: Sequence[int]) -> tuple[float, float]:
    """Mean error of CoP [m] and GRF [N] of residuals (T, s) on some runs."""
    rows = workspace.rows_of(runs)
    mask = workspace.signal_model.mask
    force, place = rows & mask[:, 0], rows & mask[:, 1]
    return (
        float(np.linalg.norm(rest[place][:, COP], axis=1).mean()),
        float(np.abs(rest[force][:, GRF]).mean()),
    )


def judged_runs(workspace: Workspace) -> tuple[int, ...]:
    """The test runs; the training runs where there is none."""
    return workspace.test or workspace.train


def shrink(workspace: Workspace, before: FloatArray, after: FloatArray) -> Shrink:
    """From residuals (T, s) without an explanation to those with it."""
    rows = workspace.rows_of(judged_runs(workspace))
    first, second = (_squares(workspace, rest, rows) for rest in (before, after))
    blocks = workspace.signal_model.samples.stretch[rows & workspace.signal_model.mask[:, 1]]
    sums = np.array(
        [
            [one[blocks == block].sum() for block in np.unique(blocks)]
            for one in (first, second, np.ones_like(first))
        ]
    )
    draws = np.random.default_rng(0).integers(0, sums.shape[1], (DRAWS, sums.shape[1]))
    fractions = [_fraction(*one) for one in sums[:, draws].sum(axis=2).T]
    low, high = np.quantile(fractions, (0.025, 0.975))
    (cop_before, grf_before), (cop_after, grf_after) = (
        maes(workspace, rest, judged_runs(workspace)) for rest in (before, after)
    )
    return Shrink(
        fraction=_fraction(*sums.sum(axis=1)),
        ci95=(float(low), float(high)),
        cop_mae_mm=(1e3 * cop_before, 1e3 * cop_after),
        grf_mae_n=(grf_before, grf_after),
    )


def excess(
    workspace: Workspace, rest: FloatArray, runs: Sequence[int], part: slice = FORCE_AND_PLACE
) -> float:
    """Mean square of the whitened errors (T, s) of GRF and CoP on some runs, less their floor."""
    return float(_squares(workspace, rest, workspace.rows_of(runs), part).mean()) - 1.0


def _fraction(before: float, after: float, count: float) -> float:
    over = before - count
    if over <= 0.0:
        return 0.0
    return float(np.clip(1.0 - max(after - count, 0.0) / over, -9.0, 1.0))


def _squares(
    workspace: Workspace,
    rest: FloatArray,
    rows: BoolArray,
    part: slice = FORCE_AND_PLACE,
) -> FloatArray:
    """(k,) mean over GRF and CoP of the squares of each of some samples (T,), in noises."""
    there = rest[rows & workspace.signal_model.mask[:, 1]][:, part]
    squares: FloatArray = ((there / workspace.floor[part]) ** 2).mean(axis=1)
    return squares
