"""Files of robot and shoes that may be right and mostly are not."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from core.drafting.drafts import draft
from core.robot import robots
from core.shoe import shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.text import robot_text
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.checks.doubtful_files import check_files
from shoecal_core.files import write_yaml
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.sole_places import misplaced_soles
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
    # Feet that are alike show nothing of their cells; the URDF's are not.
    alike = (NAO.feet[0], replace(NAO.feet[1], outline=NAO.feet[0].outline))
    (finding,) = check_files(replace(NAO, feet=alike), copied(SHOE))
    assert finding.reason.startswith("the outline of the right sole is 11 mm to the left of the")


def test_a_leg_without_its_masses_is_named() -> None:
    model = NAO.model.copy()
    model.inertias[model.getJointId("RHipPitch")].mass = 0.0
    (finding,) = check_files(replace(NAO, model=model), SHOE)
    assert finding.reason.startswith("LThigh_link and RThigh_link are 0.39 and 0 kg by the URDF")


def placed(robot: Robot, *moves: tuple[float, float], grown: float = 0.0) -> Robot:
    """With soles that were moved [m], and outlines larger or smaller about their middle."""
    feet = []
    for foot, move in zip(robot.feet, moves, strict=True):
        placement = foot.placement * pin.SE3(np.eye(3), np.array([*move, 0.0]))
        middle = 0.5 * (foot.outline.max(axis=0) + foot.outline.min(axis=0))
        size = 0.5 * np.ptp(foot.outline, axis=0)
        outline = middle + (foot.outline - middle) * (size + grown) / size
        feet.append(replace(foot, placement=placement, outline=outline))
    return replace(robot, feet=(feet[0], feet[1]))


SHAPED = [load_robot(robots.FILES[name]) for name in ("nao", "wren")]
OFFSETS = st.floats(-0.03, 0.03)


@given(st.sampled_from(SHAPED), st.tuples(OFFSETS, OFFSETS), st.floats(-0.015, 0.02))
def test_soles_off_their_feet_are_told_as_far_as_they_are(
    robot: Robot, move: tuple[float, float], grown: float
) -> None:
    """By 8 mm on both sides and more; shoes that are larger all round say nothing."""
    found = misplaced_soles(placed(robot, move, (0.0, 0.0), grown=grown))
    told = np.where(np.abs(move) > 0.008 + abs(grown) + 1e-9, move, 0.0)
    unsure = np.abs(np.abs(move) - 0.008 - abs(grown)) < 1e-6
    if unsure.any():
        return
    if not told.any():
        assert not found
        return
    (sole,) = found
    assert sole.foot == "left"
    np.testing.assert_allclose(sole.offset, told, atol=1e-9)
    foot = robot.feet[0]
    joint_R_link = robot.model.frames[foot.link].placement.rotation
    back = foot.placement.rotation @ [*-told, 0.0]
    np.testing.assert_allclose(joint_R_link @ sole.cure, back, atol=1e-9)


def test_the_cure_is_in_the_axes_of_the_link(tmp_path: Path) -> None:
    """Who adds it to the robot file's sole has the sole under the shape again."""
    text = robots.FILES["nao"].read_text().replace("../", f"{robots.FILES['nao'].parent}/../")
    values = yaml.safe_load(text)
    urdf = (robots.FILES["nao"].parent / "nao.urdf").read_text()
    mount = '<link name="turned"/><joint name="turned_mount" type="fixed">'
    mount += '<parent link="l_ankle_link"/><child link="turned"/>'
    mount += '<origin xyz="0 0 0" rpy="0 0 1.5707963267948966"/></joint>'
    (tmp_path / "nao.urdf").write_text(urdf.replace("</robot>", f"{mount}</robot>"))
    foot = values["feet"]["left"]
    values["urdf"], foot["link"], file = "nao.urdf", "turned", tmp_path / "nao.yaml"
    foot["sole_rpy_rad"] = [0, 0, -np.pi / 2]
    foot["sole_xyz_m"] = [0.0, -0.02, foot["sole_xyz_m"][2]]  # 20 mm ahead is -y of that link
    write_yaml(file, values)
    (sole,) = misplaced_soles(load_robot(file))
    np.testing.assert_allclose(sole.offset, [0.02, 0.0], atol=1e-9)
    np.testing.assert_allclose(sole.cure, [0.0, 0.02, 0.0], atol=1e-9)
    foot["sole_xyz_m"] = [
        value + by for value, by in zip(foot["sole_xyz_m"], sole.cure.tolist(), strict=True)
    ]
    write_yaml(file, values)
    assert not misplaced_soles(load_robot(file))


def test_a_sole_off_the_foot_is_named_with_the_cure() -> None:
    (finding,) = check_files(placed(NAO, (0.014, 0.0), (0.014, 0.0)), SHOE)
    assert finding.verdict == "WARN"
    assert finding.reason == (
        "the outline of the left and the right sole is 14 mm ahead of the shape that the URDF "
        "gives the foot, and leaves as much of it free on the other side: the CoP is off by that; "
        "add [-0.014, 0, 0] to feet.left.sole_xyz_m and feet.right.sole_xyz_m of the robot file, "
        "unless outline_m alone is wrong"
    )
    both = check_files(placed(NAO, (0.0, 0.012), (-0.01, -0.012)), SHOE)
    assert [one.reason.partition(" of the shape")[0] for one in both] == [
        "the outline of the left sole is 12 mm to the left",
        "the outline of the right sole is 10 mm behind and 12 mm to the right",
    ]


def test_an_outline_longer_at_one_end_is_no_other_place() -> None:
    """A toe cap, or a shape without the toes."""
    for at in (0, 1):
        for by in (-0.03, 0.03):
            outline = NAO.feet[0].outline.copy()
            end = outline[:, 0] == (outline.max(axis=0), outline.min(axis=0))[at][0]
            outline[end, 0] += by
            assert not misplaced_soles(with_outline(outline))


def with_outline(outline: FloatArray) -> Robot:
    return replace(NAO, feet=(replace(NAO.feet[0], outline=outline), NAO.feet[1]))


@pytest.mark.parametrize("name", ["nao", "wren"])
def test_drafts_are_not_doubted(name: str, tmp_path: Path) -> None:
    file = tmp_path / "drafted.yaml"
    file.write_text(robot_text(draft(name), str(robots.FILES[name].with_suffix(".urdf"))))
    robot = load_robot(file)
    assert not misplaced_soles(robot)
    assert misplaced_soles(placed(robot, (-0.012, 0.0), (0.0, 0.0)))


def test_feet_without_a_shape_say_nothing(tmp_path: Path) -> None:
    text = re.sub(r"<(collision|visual)>.*?</\1>", "", NAO.urdf.read_text(), flags=re.DOTALL)
    bare, lost = tmp_path / "bare.urdf", tmp_path / "lost.urdf"
    bare.write_text(text)
    mesh = '<visual><geometry><mesh filename="package://gone/foot.stl"/></geometry></visual>'
    lost.write_text(text.replace('<link name="l_ankle_link">', f'<link name="l_ankle_link">{mesh}'))
    broken = tmp_path / "broken.urdf"
    broken.write_text("no robot")
    far = placed(NAO, (0.03, 0.0), (0.03, 0.0))
    assert len(misplaced_soles(far)) == 2
    for urdf in (bare, lost, broken):
        assert not misplaced_soles(replace(far, urdf=urdf))


@pytest.mark.parametrize(
    "wrong",
    [{"link_com_m": 3.0}, {"joint_zero_rad": 0.6}, {"delay_s": 15.0}, {"link_mass": 2.0},
     {"cell_position_m": -0.001}],
)  # fmt: skip
def test_tolerances_in_another_unit_are_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(SettingError, match="must be at least 0 and at most"):
        Tolerances(**wrong)


def shifted(shoe: Shoe, feet: set[int], by: tuple[float, float]) -> Shoe:
    """The cells of these feet at other places."""
    channels = tuple(
        replace(one, position=one.position + by) if one.foot in feet else one
        for one in shoe.channels
    )
    return replace(shoe, channels=channels)


def test_cells_off_the_soles_are_named() -> None:
    """Of a shoe file whose places are measured from the heel: no fit notices those of both feet."""
    wren, shoe = robots.load("wren"), shoes.shoe("wren_shoe")
    (finding,) = check_files(wren, shifted(shoe, {0, 1}, (0.05, 0.0)))
    assert finding.verdict == "WARN"
    assert finding.reason.startswith("the cells of the left and the right foot stand out of the")
    assert "mm ahead of the outline's" in finding.reason
    (finding,) = check_files(wren, shifted(shoe, {1}, (0.0, -0.05)))
    assert finding.reason.startswith("the cells of the right foot stand out")
    assert "mm to the right of the outline's" in finding.reason
    assert not check_files(wren, shifted(shoe, {0, 1}, (0.005, 0.0)))
