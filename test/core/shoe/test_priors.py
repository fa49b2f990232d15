"""What is believed of gains and offsets before any sample."""

from __future__ import annotations

import numpy as np
import pytest

from core.shoe import shoes
from shoecal_core.shoe.priors import TORQUE_LEVER_M, USUAL_WEIGHT, PriorSettings, parameter_std

SETTINGS = PriorSettings(gain_std=0.8, nominal_gain_std=0.05, offset_std_n=20.0)


def test_gains_by_their_size_and_data_sheet() -> None:
    origin = [0.0, 0.0, 0.1]
    shoe = shoes.made([*shoes.six_axis(0, origin, gain=2.0), *shoes.six_axis(1, origin, gain=None)])
    std = parameter_std(shoe, np.full(10, -2.0), 0.0, SETTINGS)
    np.testing.assert_allclose(std[:5], 2.0 * 0.05)
    np.testing.assert_allclose(std[5:10], 2.0 * 0.8)
    unit = np.where(shoe.torque, TORQUE_LEVER_M, 1.0)
    np.testing.assert_allclose(std[10:], 20.0 * unit)


@pytest.mark.parametrize(("weight", "factor"), [(10.0, 1.0), (USUAL_WEIGHT, 1.0), (520.0, 10.0)])
def test_offsets_of_heavier_robots_may_be_larger(weight: float, factor: float) -> None:
    shoe = shoes.made(shoes.six_axis(0, [0.0, 0.0, 0.1], gain=None))
    std = parameter_std(shoe, np.ones(5), weight, SETTINGS)
    light = parameter_std(shoe, np.ones(5), 0.0, SETTINGS)
    np.testing.assert_allclose(std[5:], factor * light[5:])
    np.testing.assert_array_equal(std[:5], light[:5])
