"""Files of robot and shoes that may be right and mostly are not."""

from __future__ import annotations

from dataclasses import replace

import pytest

from core.robot import robots
from core.shoe import shoes
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.doubtful_files import check_files
from shoecal_core.settings import SettingError
from shoecal_core.shoe.shoe import Shoe

NAO, SHOE = robots.load("nao"), shoes.shoe("nao_shoe")


@pytest.mark.parametrize("name", robots.NAMES)
def test_nothing_is_doubted_of_known_robots(name: str) -> None:
    assert not check_files(robots.load(name), shoes.shoe(robots.SHOES[name]))


def test_shoes_with_a_slip_of_the_decimal_point_are_weighed() -> None:
    heavy = tuple(replace(one, mass_above=10.0 * one.mass_above) for one in SHOE.plates)
    (finding,) = check_files(NAO, replace(SHOE, plates=(heavy[0], heavy[1])))
    assert finding.verdict == "WARN"
    assert "of the 5.5 kg of robot and shoes: put the shoes on a scale" in finding.reason


def copied(shoe: Shoe) -> Shoe:
    """The right cells at the left ones' places."""
    channels = list(shoe.channels)
    for left, right in zip(shoe.of_foot(0), shoe.of_foot(1), strict=True):
        channels[right] = replace(channels[right], position=channels[left].position)
    return replace(shoe, channels=tuple(channels))


def test_cells_of_the_other_foot_are_named() -> None:
    (finding,) = check_files(NAO, copied(SHOE))
    assert "up to 11 mm apart from mirrored ones; give the right ones' y" in finding.reason
    # Feet that are alike show nothing.
    alike = (NAO.feet[0], replace(NAO.feet[1], outline=NAO.feet[0].outline))
    assert not check_files(replace(NAO, feet=alike), copied(SHOE))


def test_a_leg_without_its_masses_is_named() -> None:
    model = NAO.model.copy()
    model.inertias[model.getJointId("RHipPitch")].mass = 0.0
    (finding,) = check_files(replace(NAO, model=model), SHOE)
    assert finding.reason.startswith("LThigh_link and RThigh_link are 0.39 and 0 kg by the URDF")


@pytest.mark.parametrize(
    "wrong",
    [{"link_com_m": 3.0}, {"joint_zero_rad": 0.6}, {"delay_s": 15.0}, {"link_mass": 2.0},
     {"cell_position_m": -0.001}],
)  # fmt: skip
def test_tolerances_in_another_unit_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(SettingError, match="must be at least 0 and at most"):
        Tolerances(**wrong)
