"""Both shoes, and truths to find again."""

from __future__ import annotations

import numpy as np
import pytest

from core.calibration import synthetic
from core.sensing import shoes
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters


@pytest.fixture(params=shoes.NAMES)
def shoe(request: pytest.FixtureRequest) -> Shoe:
    return shoes.shoe(request.param)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20)


@pytest.fixture
def truth(shoe: Shoe, rng: np.random.Generator) -> ChannelParameters:
    return synthetic.truth(shoe, rng)
