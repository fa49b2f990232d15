"""What a calibration would absorb of an effect: errors of the CoP that no residual shows."""

from __future__ import annotations

import numpy as np

from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signals import COP


def hidden_cop(workspace: Workspace, scored: Scored, index: int) -> float:
    """Mean length of the CoP error that gains and offsets would make up for [m]."""
    added = workspace.added(scored, scored.own(index))
    absorbed = added - workspace.calibrated(added)
    return float(np.linalg.norm(absorbed[workspace.signal_model.mask[:, 1]][:, COP], axis=1).mean())
