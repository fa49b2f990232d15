"""What the CoP's gap is made of: causes, tolerance errors by source, and what nothing explains.

Of residuals r and a source's contribution c (T, 2) the share is  sum(r c) / sum(r^2):  shares of
everything together add up to 1, and a source that works against the others has a negative one.
"""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.result import BudgetShare
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.shrink import judged_runs
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import COP
from shoecal_core.samples.zeros import NORMAL_95

LEAST_SHARE = 0.05
"""Smaller ones of a source are put together over its places."""
MOST = 12
"""Sources that are listed by themselves."""


def budget(
    workspace: Workspace, rest: FloatArray, chosen: Scored | None
) -> tuple[BudgetShare, ...]:
    """Shares of the CoP's mean square on the test runs, the largest first.

    Args:
        workspace: with tolerance errors as the explanation leaves them.
        rest: (T, s) residuals with nothing added.
        chosen: the explanation.
    """
    rows = workspace.rows_of(judged_runs(workspace))
    there = workspace.signal_model.mask[rows][:, COP]
    own = np.where(there, rest[rows][:, COP], 0.0)
    whole = float((own**2).sum())
    if whole == 0.0:
        return ()
    # Of each column of the fit, what one unit of it holds.
    built = workspace.built
    slopes = np.zeros(len(built.vector))
    errors, left = workspace.left_of_errors
    slopes[errors] = np.einsum("ets,ts->e", left[:, :, COP], own) / whole
    keys: dict[int, tuple[str, tuple[str, ...]]] = {}
    for column, error in zip(
        np.flatnonzero(workspace.signal_model.built).tolist(),
        workspace.signal_model.deviations,
        strict=True,
    ):
        keys[column] = error.effect, error.location
    if chosen is not None:
        columns = workspace.catalogue.columns[list(chosen.columns)]
        added = workspace.calibrated(columns)[:, rows][:, :, COP] * there
        slopes[len(slopes) - len(added) :] = np.einsum("ets,ts->e", added, own) / whole
        for at, (hypothesis, _) in enumerate(chosen.parts):
            for column in np.arange(len(slopes))[chosen.own(at)].tolist():
                keys[column] = hypothesis.effect.identifier, hypothesis.place
    return _listed(keys, slopes, built)


def _listed(
    keys: dict[int, tuple[str, tuple[str, ...]]], slopes: FloatArray, built: Scored
) -> tuple[BudgetShare, ...]:
    covariance = built.covariance

    def share(source: str, location: tuple[str, ...], columns: list[int]) -> BudgetShare:
        value = float(slopes[columns] @ built.vector[columns])
        spread = slopes[columns] @ covariance[np.ix_(columns, columns)] @ slopes[columns]
        half = NORMAL_95 * float(np.sqrt(max(float(spread), 0.0)))
        return BudgetShare(source, location, value, (value - half, value + half))

    groups: dict[tuple[str, tuple[str, ...]], list[int]] = {}
    for column, key in keys.items():
        groups.setdefault(key, []).append(column)
    large: list[BudgetShare] = []
    small: dict[str, list[int]] = {}
    for (source, location), columns in groups.items():
        one = share(source, location, columns)
        if abs(one.cop_share) >= LEAST_SHARE:
            large.append(one)
        else:
            small.setdefault(source, []).extend(columns)
    large += [share(source, (), columns) for source, columns in small.items()]
    large.sort(key=lambda one: -abs(one.cop_share))
    found = large[:MOST]
    everything = share("", (), list(keys))
    kept = sum(one.cop_share for one in found)
    low, high = everything.ci95
    found += [
        BudgetShare(
            "other errors as built", (), everything.cop_share - kept, (low - kept, high - kept)
        ),
        BudgetShare("not explained", (), 1.0 - everything.cop_share, (1.0 - high, 1.0 - low)),
    ]
    return tuple(found)
