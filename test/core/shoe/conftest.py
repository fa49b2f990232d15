"""Both shoes."""

from __future__ import annotations

import pytest

from core.shoe import shoes
from shoecal_core.shoe.shoe import Shoe


@pytest.fixture(params=shoes.NAMES)
def shoe(request: pytest.FixtureRequest) -> Shoe:
    """Every shoe that comes as a file."""
    return shoes.shoe(request.param)
