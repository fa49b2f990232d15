"""The run that would best separate what is confused."""

from __future__ import annotations

from collections.abc import Sequence

from shoecal_core.diagnosis.result import NextMotion
from shoecal_core.diagnosis.scoring import Scored
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace


def propose(
    workspace: Workspace, rivals: Sequence[tuple[Scored, float]], settings: DiagnosisSettings
) -> NextMotion | None:
    """Choose it."""
    del workspace, rivals, settings
    return None
