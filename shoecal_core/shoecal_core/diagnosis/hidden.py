"""What a calibration would absorb of an effect: errors of the CoP that no residual shows."""

from __future__ import annotations

import numpy as np

from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.regression import solve
from shoecal_core.error_sources.signals import COP


def hidden_cop(workspace: Workspace, scored: Scored, index: int) -> float:
    """Mean length of the CoP error that gains and offsets would make up for [m]."""
    _, form = scored.parts[index]
    scene = workspace.scene
    added = np.tensordot(
        scored.solution.vector[scored.own(index)],
        workspace.catalogue.columns[list(form.columns)],
        1,
    )
    rows = workspace.rows_of(workspace.train)
    whitened = workspace.whitening(np.concatenate((scene.baseline, added[None])))[:, rows]
    flat = whitened[:, scene.mask[rows]]
    fitted = solve(flat @ flat.T, workspace.sums, (), np.zeros(0)).vector
    channels = 2 * len(scene.parameters.gain)
    absorbed = np.tensordot(fitted[:channels], scene.baseline[:channels], 1)
    return float(np.linalg.norm(absorbed[scene.mask[:, 1]][:, COP], axis=1).mean())
