"""Weights of one robot that contradict each other are refused, with all of them."""

from __future__ import annotations

from pathlib import Path

import pytest

from core.shoe.shoes import ROOT
from core.shoe.shoes import shoe as load_shoe
from shoecal_core.errors import FieldError
from shoecal_core.files import Fields
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.weights import RobotWeights

FIELDS = Fields(Path("robot.yaml"), "weight", {"mass_kg": 5.3, "std_kg": 0.05})


@pytest.mark.parametrize(
    ("urdf", "file", "std", "given"),
    [
        (5.0, 5.3, 0.05, None), (5.3, 5.3, 0.05, 5.8), (68.6, 68.6, 5.0, 77.7),
        (4.0, 5.3, 0.3, None),
    ],
)  # fmt: skip
def test_weights_that_agree(urdf: float, file: float, std: float, given: float | None) -> None:
    """To a tenth, or to five standard deviations of what is known of one."""
    RobotWeights(urdf, file, std, given).check(FIELDS)


@pytest.mark.parametrize(
    ("urdf", "file", "given", "told"),
    [
        (4.5, 5.3, None, "5.3 kg by this file and 4.5 kg by the URDF's masses; weigh the robot"),
        (5.3, 5300.0, None, "(it looks like grams: give kg)"),
        (5.3, 52.0, None, "(it looks like newtons: give kg)"),
        (5.3, 11.7, None, "(it looks like pounds: give kg)"),
        (5.3, 5.3, 10.0, "--weight-kg: 10.2 kg with shoes contradicts robot.yaml"),
        (5.3, 5.3, 52.0, "(it looks like newtons: give kg)"),
    ],
)
def test_weights_that_contradict_each_other(
    urdf: float, file: float, given: float | None, told: str
) -> None:
    with pytest.raises(FieldError) as caught:
        RobotWeights(urdf, file, 0.05, given, shoes=0.2).check(FIELDS)
    assert told in str(caught.value)
    assert f"{urdf:.4g} kg by the URDF's masses" in str(caught.value)


def test_every_reader_of_a_robot_file_asks() -> None:
    shoe = load_shoe("nao_shoe")
    robot = ROOT / "config/robots/nao.yaml"
    assert load_robot(robot, shoe, weight_kg=5.6).mass == pytest.approx(5.6)
    with pytest.raises(FieldError, match="its shoes"):
        load_robot(robot, shoe, weight_kg=10.0)
    with pytest.raises(FieldError, match="contradicts"):
        load_robot(robot, shoe, weight_kg=0.5 * shoe.mass)
