"""The recorded signal model that effects are put into."""

from __future__ import annotations

import pytest

from core.error_sources.altered import calm
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.signal_model import SignalModel


@pytest.fixture(scope="session")
def signal_model(workspace: Workspace) -> SignalModel:
    """Nothing wrong, no noise: six double supports, two runs with a foot in the air."""
    return calm(workspace.signal_model)
