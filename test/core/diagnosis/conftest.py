"""What may be run next."""

from __future__ import annotations

import pytest

from shoecal_core.diagnosis.candidates import possible_runs
from shoecal_core.diagnosis.forecast import PossibleRun
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.planning.settings import PlannerSettings


@pytest.fixture(scope="session")
def runs(workspace: Workspace) -> tuple[PossibleRun, ...]:
    """Every motion that could be run next."""
    return possible_runs(workspace.scene, PlannerSettings())
