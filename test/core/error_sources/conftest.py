"""The recorded scene that effects are put into."""

from __future__ import annotations

import pytest

from core.error_sources.altered import calm
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.scene import Scene


@pytest.fixture(scope="session")
def scene(workspace: Workspace) -> Scene:
    """Nothing wrong, no noise: six double supports, two runs with a foot in the air."""
    return calm(workspace.scene)
