"""What may be run next, and sessions drawn from the diagnosis' own statistics."""

from __future__ import annotations

import pytest

from core.diagnosis.drawn import Urn
from shoecal_core.diagnosis.candidates import possible_runs
from shoecal_core.diagnosis.forecast import PossibleRun
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.planning.settings import PlannerSettings


@pytest.fixture(scope="session")
def runs(workspace: Workspace) -> tuple[PossibleRun, ...]:
    """Every motion that could be run next."""
    return possible_runs(workspace.scene, PlannerSettings())


@pytest.fixture(scope="session")
def urn(workspace: Workspace) -> Urn:
    """Draws sessions with that layout."""
    return Urn.of(workspace)
