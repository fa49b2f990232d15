"""Joint fits of made-up sessions whose truth is drawn from the tolerances."""

from __future__ import annotations

import pytest

from core.estimation.drawn import Drawn, drawn


@pytest.fixture(scope="session")
def known() -> Drawn:
    """One robot with all as-built errors, fitted."""
    return drawn(1)
