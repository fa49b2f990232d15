"""What a session can tell, before anything is named."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace


@dataclass(frozen=True)
class Preflight:
    """What cannot be seen, and what cannot be told apart."""

    cannot_detect: tuple[str, ...]
    cannot_separate: tuple[tuple[str, ...], ...]


def preflight(workspace: Workspace, settings: DiagnosisSettings) -> Preflight:
    """Of a session."""
    del settings
    return Preflight(workspace.library.lacking, ())
