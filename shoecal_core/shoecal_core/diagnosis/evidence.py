"""What pictures of a diagnosis are drawn from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from shoecal_core.diagnosis.result import Evidence, Fitted, NamedHypothesis
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import SIGNALS
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.wrench import cop

RIVALS = 4
"""Hypotheses whose fit is shown next to the chosen one."""


def evidence(workspace: Workspace, chosen: Scored | None, rivals: Sequence[Scored]) -> Evidence:
    """Arrays of all samples, test runs included.

    Args:
        chosen: the explanation; None where nothing was found.
        rivals: hypotheses by themselves, the best first.
    """
    signal_model = workspace.signal_model
    samples = signal_model.samples
    supports = np.array([[one.dx, one.dy, one.dtheta] for one in signal_model.supports])
    return Evidence(
        signals=SIGNALS,
        run=samples.run,
        time=samples.time,
        test=workspace.rows_of(workspace.test),
        loaded=samples.loaded,
        support=supports[samples.segment],
        cop=samples.cop,
        foot_cop=cop(signal_model.foot_wrenches, MINIMUM_FORCE),
        foot_force=signal_model.foot_wrenches[..., 0],
        outputs=signal_model.outputs,
        noise=workspace.floor,
        without=_fitted(workspace, None, "nothing added"),
        explained=None if chosen is None else _fitted(workspace, chosen, "what was found"),
        rivals=tuple(_fitted(workspace, one, label(one)) for one in rivals[:RIVALS]),
    )


def label(scored: Scored) -> str:
    """Of all parts together, for a person to read."""
    return " and ".join(
        NamedHypothesis(hypothesis.effect.identifier, hypothesis.place, 0.0).label
        for hypothesis, _ in scored.parts
    )


def _fitted(workspace: Workspace, scored: Scored | None, name: str) -> Fitted:
    rest, added = workspace.explained(scored)
    mask = workspace.signal_model.mask
    return Fitted(name, np.where(mask, rest, np.nan), np.where(mask, added, np.nan))
