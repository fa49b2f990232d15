"""Both robots, read once a test run."""

from __future__ import annotations

import pytest

from core.simulation.worlds import NAMES, World, load_world


@pytest.fixture(params=NAMES)
def world(request: pytest.FixtureRequest) -> World:
    """Every robot that the simulation is tested with."""
    return load_world(request.param)


@pytest.fixture
def nao() -> World:
    return load_world("nao")
