"""The weight by data sheets, on steps with known weight and zeros."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.weight import weigh
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.samples.zeros import Zero, zeros_of_run
from shoecal_core.shoe.shoe_file import load_shoe

ANKLES = load_shoe(shoes.ROOT / "config/shoes/reemc.yaml")
KG = 77.7
TIME = np.arange(0.0, 24.0, 0.02)


def trial(run: int, rng: np.random.Generator) -> tuple[FloatArray, list[Zero]]:
    """A walk that bobs, with zeros of its own."""
    phase = TIME % 2.4 / 2.4
    left = np.interp(phase, (0.0, 0.1, 0.2, 0.5, 0.6, 0.9, 1.0), (0.5, 1, 1, 0, 0, 0, 0.5))
    left = np.where((phase > 0.5) & (phase < 0.85), 0.0, left)
    bob = 1.0 + 0.1 * np.sin(4.0 * np.pi * phase)
    readings = rng.standard_normal((len(TIME), 10))
    zeros = rng.normal(-60.0, 20.0, 2)
    for foot, share in enumerate((left, 1.0 - left)):
        readings[:, 5 * foot + 2] += GRAVITY * KG * share * bob + zeros[foot]
    air = np.stack((left == 0.0, left == 1.0), axis=1)
    return readings, zeros_of_run(run, TIME, readings, air)


def trials(count: int) -> tuple[dict[int, FloatArray], list[Zero]]:
    rng = np.random.default_rng(9)
    found = {run: trial(run, rng) for run in range(1, count + 1)}
    return {run: one[0] for run, one in found.items()}, [
        zero for _, zeros in found.values() for zero in zeros
    ]


@pytest.mark.parametrize("count", [1, 4])
def test_the_weight_is_within_one_per_cent_whatever_the_zeros(count: int) -> None:
    readings, zeros = trials(count)
    found = weigh(ANKLES, readings, zeros)
    assert found is not None
    assert found.kg == pytest.approx(KG, rel=0.003)
    assert found.ci95[0] < KG < found.ci95[1]
    assert found.ci95[1] - found.ci95[0] < 0.02 * KG
    assert found.runs == tuple(range(1, count + 1))
    assert found.to_json()["data_sheet_kg"] == found.kg


def test_without_data_sheets_or_zeros_there_is_none() -> None:
    readings, zeros = trials(1)
    assert weigh(ANKLES, readings, [zero for zero in zeros if zero.foot == 0]) is None
    unknown = replace(
        ANKLES, channels=tuple(replace(one, nominal_gain=None) for one in ANKLES.channels)
    )
    assert weigh(unknown, readings, zeros) is None
