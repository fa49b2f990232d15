from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.shoe.correction import CopCorrection, corrected_channels
from shoecal_core.shoe.instant import InstantSensing
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe, load_shoe
from shoecal_core.shoe.wrench import ChannelParameters

ROOT = Path(__file__).parents[3]
SHOES = [
    load_shoe(ROOT / path)
    for path in ("config/shoes/nao_shoe.yaml", "config/shoes/reemc.yaml",
                 "test/data/shoes/odd_shoe.yaml")
]  # fmt: skip


def drawn_correction(shoe: Shoe, foot: int, rng: np.random.Generator) -> CopCorrection:
    count = len(corrected_channels(shoe, foot))
    return CopCorrection(
        foot,
        rng.normal(0.0, 0.05, 4 + count),
        rng.normal(0.0, 0.05, 4 + count),
        np.sort(rng.normal(0.0, 0.05, (2, 2)), axis=0),
        np.sort(rng.normal(10.0, 20.0, (2, count)), axis=0),
    )


@given(st.integers(0, 2**32 - 1), st.sampled_from(SHOES), st.integers(0, 3), st.booleans())
def test_it_is_what_the_batch_gives(seed: int, shoe: Shoe, corrected: int, gone: bool) -> None:
    rng = np.random.default_rng(seed)
    count = len(shoe.names)
    law = ChannelParameters(rng.normal(0.0, 10.0, count), rng.normal(0.0, 3.0, count))
    corrections = [drawn_correction(shoe, foot, rng) for foot in (0, 1) if corrected & (1 + foot)]
    sensing = Sensing(shoe, law, corrections)
    readings = rng.normal(0.0, 2.0, count)
    if gone:
        readings[rng.integers(count)] = math.nan
    measured = sensing.measure(readings)
    for foot, found in enumerate(InstantSensing(sensing).measure(readings.tolist())):
        np.testing.assert_allclose(found.force, measured.grf[foot], rtol=1e-9, atol=1e-9)
        expected = measured.cop[foot]
        if found.cop is None:
            assert not np.isfinite(expected).all()
            continue
        np.testing.assert_allclose(found.cop, expected, rtol=1e-9, atol=1e-9)
        assert found.extrapolating == measured.extrapolating[foot]
