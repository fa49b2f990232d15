"""Data sheets against data: which of the two is believed, and what is said of the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.robot import robots
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.checks.data_sheets import (
    check_conflict,
    check_data_sheets,
    check_weight,
    contradicts,
    without_sheets,
)
from shoecal_core.shoe.wrench import ChannelParameters

SHOE = shoes.made([*shoes.six_axis(0, [0, 0, 0.05]), *shoes.six_axis(1, [0, 0, 0.05])])
COUNT = len(SHOE.names)
STD = 0.05
ROBOT = robots.load("nao")


def law(ratio: float | FloatArray) -> ChannelParameters:
    """Gains so many times their data sheets'."""
    return ChannelParameters(ratio * np.ones(COUNT), np.zeros(COUNT))


def test_gains_near_their_data_sheets_are_no_conflict() -> None:
    assert not contradicts(SHOE, law(1.2), STD)
    assert check_conflict(SHOE, law(1.2), None, STD) == []
    assert contradicts(SHOE, law(1.3), STD)
    nothing = without_sheets(SHOE)
    assert not contradicts(nothing, law(100.0), STD)
    assert check_conflict(nothing, law(100.0), None, STD) == []


@pytest.mark.parametrize(
    ("ratio", "told"),
    [
        (9.7, "in kgf or kg?"), (4.4, "in lbf or lb?"), (0.0098, "in gf or g?"),
        (2.05, "half a bridge"), (3e4, "counts of a converter?"), (2e-5, "counts of a converter?"),
    ],
)  # fmt: skip
def test_a_compromise_fails_and_the_likely_unit_is_named(ratio: float, told: str) -> None:
    (finding,) = check_conflict(SHOE, law(np.sqrt(ratio)), law(ratio), STD)
    assert finding.verdict == "FAIL"
    assert f"without the data sheets the data give left/fz {ratio:.3g}" in finding.reason
    assert told in finding.reason
    assert "correct 'nominal_gain'" in finding.reason


def test_no_unit_is_guessed_where_gains_disagree() -> None:
    alone = law(9.7 * np.linspace(0.5, 1.5, COUNT))
    (finding,) = check_conflict(SHOE, law(3.0), alone, STD)
    assert "are the readings" not in finding.reason
    (finding,) = check_conflict(SHOE, law(3.0), None, STD)
    assert "without the data sheets" not in finding.reason


def test_a_weight_is_told_only_by_gains_that_agree() -> None:
    (finding,) = check_weight(SHOE, law(0.8), None, None, ROBOT)
    assert f"weighs {ROBOT.mass / 0.8:.1f} kg by them" in finding.reason
    apart = law(np.where(np.arange(COUNT) < COUNT // 2, 0.6, 0.95))
    assert check_weight(SHOE, apart, np.full(COUNT, 0.01), None, ROBOT) == []
    # As far apart as their own uncertainty lets them be, they do agree.
    assert len(check_weight(SHOE, apart, np.full(COUNT, 0.2), None, ROBOT)) == 1


def test_one_gain_unlike_its_data_sheet_is_a_warning() -> None:
    gains = np.ones(COUNT)
    gains[1] = 0.7
    (finding,) = check_data_sheets(SHOE, law(gains), np.full(COUNT, 0.02))
    assert finding.verdict == "WARN"
    assert f"{SHOE.names[1]} 0.70 ± 0.04" in finding.reason
    assert check_data_sheets(SHOE, law(gains), np.full(COUNT, 0.2)) == []


def test_only_what_is_said_of_gains_goes() -> None:
    bare = without_sheets(SHOE)
    assert {channel.nominal_gain for channel in bare.channels} == {None}
    assert replace(bare, channels=SHOE.channels) == SHOE
