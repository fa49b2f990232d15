"""Both robots, built once a test run."""

from __future__ import annotations

import pytest

from core.planning.bodies import NAMES, Body, load_body


@pytest.fixture(scope="session", params=NAMES)
def body(request: pytest.FixtureRequest) -> Body:
    """Every robot that planning is tested with."""
    return load_body(request.param)


@pytest.fixture(scope="session")
def nao() -> Body:
    return load_body("nao")
