"""Drafts against what people who know the robots wrote by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import shapely

from core.drafting.drafts import ROBOTS, draft, edited
from core.robot import robots
from shoecal_core.drafting.draft import draft_robot, prove
from shoecal_core.drafting.notes import robot_notes, shoe_notes
from shoecal_core.drafting.simulated import small_deflection
from shoecal_core.drafting.text import robot_text, shoe_text
from shoecal_core.errors import FileError
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import JointDeflection, Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe

NAMES = ("nao", "wren")
MILLIMETRE = 1e-3
SENSOR = """<link name="sensor_{0}"/><joint name="{0}_ankle_ft_sensor" type="fixed">
    <parent link="{0}_sole"/><child link="sensor_{0}"/>
    <origin xyz="0.01 0 0.004" rpy="0 {1} 0"/></joint>"""


def loaded(name: str, folder: Path) -> tuple[Robot, Shoe]:
    """The draft as the other commands read it."""
    robot, shoe = folder / f"{name}.yaml", folder / "shoe.yaml"
    robot.write_text(robot_text(draft(name), str(ROBOTS / f"{name}.urdf")))
    shoe.write_text(shoe_text(draft(name)))
    return load_robot(robot), load_shoe(shoe)


@pytest.mark.parametrize("name", NAMES)
def test_soles_are_those_drawn_by_hand(name: str, tmp_path: Path) -> None:
    drafted, _ = loaded(name, tmp_path)
    for found, meant in zip(drafted.feet, robots.load(name, shod=False).feet, strict=True):
        between = meant.placement.actInv(found.placement)
        assert found.joint == meant.joint
        assert np.linalg.norm(between.translation) < MILLIMETRE
        assert np.allclose(between.rotation, np.eye(3), atol=1e-6)
        outlines = shapely.Polygon(found.outline), shapely.Polygon(meant.outline)
        assert shapely.hausdorff_distance(*outlines) < MILLIMETRE


@pytest.mark.parametrize("name", NAMES)
def test_legs_and_motors_are_those_written_by_hand(name: str, tmp_path: Path) -> None:
    drafted, shoe = loaded(name, tmp_path)
    meant = robots.load(name, shod=False)
    assert drafted.leg_names == meant.leg_names
    assert drafted.shared == meant.shared
    assert drafted.mass == pytest.approx(meant.mass, rel=0.03)
    assert len(shoe.channels) == 8


@pytest.mark.parametrize("name", NAMES)
def test_the_posture_stands(name: str, tmp_path: Path) -> None:
    """Soles level and beside each other, the CoM above them, knees bent the robot's own way."""
    drafted, _ = loaded(name, tmp_path)
    meant = robots.load(name, shod=False)
    state = Kinematics(drafted).states(drafted.posture[None])
    assert np.allclose(state.rotation[0], np.eye(3), atol=5e-3)
    assert abs(state.translation[0, 2]) < MILLIMETRE
    for foot, com in zip(drafted.feet, state.com[0], strict=True):
        low, high = foot.outline[:, 0].min(), foot.outline[:, 0].max()
        assert low < com[0] < high
    knees = [drafted.joint(joint) for joint in drafted.leg_names if "nee" in joint]
    assert np.array_equal(np.sign(drafted.posture[knees]), np.sign(meant.posture[knees]))


@pytest.mark.parametrize("name", NAMES)
def test_capsules_lie_about_those_drawn_by_hand(name: str, tmp_path: Path) -> None:
    drafted, _ = loaded(name, tmp_path)
    meant = {capsule.name: capsule for capsule in robots.load(name, shod=False).capsules}
    thighs = [capsule for capsule in drafted.capsules if capsule.name.endswith("thigh")]
    assert len(thighs) == 2
    for capsule in thighs:
        by_hand = meant[capsule.name]
        assert capsule.joint == by_hand.joint
        assert capsule.radius == pytest.approx(by_hand.radius, abs=MILLIMETRE)
        ends = np.sort(np.stack([capsule.start, capsule.end]), axis=0)
        assert np.allclose(
            ends, np.sort(np.stack([by_hand.start, by_hand.end]), axis=0), atol=MILLIMETRE
        )


def test_every_block_says_what_to_check() -> None:
    text = robot_text(draft("wren"), "wren.urdf")
    notes = robot_notes(draft("wren"))
    assert {note.field for note in notes} == {
        "weight", "feet", "legs", "posture_rad", "support_range", "friction", "joint_deflection",
        "capsules",
    }  # fmt: skip
    assert text.count("CHECK:") == len(notes)
    assert shoe_text(draft("wren")).count("CHECK:") == len(shoe_notes(draft("wren")))


def test_names_that_yaml_would_read_otherwise(tmp_path: Path) -> None:
    file = edited(tmp_path, "wren", "left_knee", "off")
    found = draft_robot(file, "on")
    robot = tmp_path / "robot.yaml"
    robot.write_text(robot_text(found, "wren.urdf"))
    assert load_robot(robot).name == "on"
    assert "off" in load_robot(robot).leg_names


def test_six_axis_sensors_by_their_names(tmp_path: Path) -> None:
    """Axes against the sole's get a negative polarity; the place is in the sole frame."""
    sensors = "".join(SENSOR.format(side, "-1.5707963") for side in ("left", "right"))
    file = edited(tmp_path, "wren", "</robot>", f"{sensors}</robot>")
    found = draft_robot(file, "wren")
    text = shoe_text(found)
    prove(found, robot_text(found, "wren.urdf"), text)
    (tmp_path / "shoe.yaml").write_text(text)
    shoe = load_shoe(tmp_path / "shoe.yaml")
    assert shoe.names[:5] == ("left/fx", "left/fy", "left/fz", "left/mx", "left/my")
    sensor = found.six_axis[0]
    assert sensor is not None
    assert sensor.name == "left_ankle_ft_sensor"
    assert np.allclose(sensor.origin, [0.004, 0.0, 0.026], atol=1e-6)
    assert sensor.signs == (1, 1, 1)


def test_sensors_askew_are_told(tmp_path: Path) -> None:
    sensors = "".join(SENSOR.format(side, "0.3") for side in ("left", "right"))
    file = edited(tmp_path, "wren", "</robot>", f"{sensors}</robot>")
    told = [note.found for note in shoe_notes(draft_robot(file, "wren"))]
    assert "Its axes are not parallel to the sole's." in told


def test_six_axis_feet_that_no_name_tells(tmp_path: Path) -> None:
    found = draft_robot(ROBOTS / "nao.urdf", "nao", six_axis=True)
    sensor = found.six_axis[1]
    assert sensor is not None
    assert np.allclose(sensor.origin, [0.0, 0.0, 0.04519])
    prove(found, robot_text(found, "nao.urdf"), shoe_text(found))


def test_left_and_right_without_names(tmp_path: Path) -> None:
    """The base looks along x, so the left leg is the one at positive y."""
    file = edited(tmp_path, "wren", r"\b(left|right)_", lambda m: {"l": "a_", "r": "b_"}[m[0][0]])  # type: ignore[arg-type]
    found = draft_robot(file, "wren")
    assert found.leg_names[0] == "a_hip_turn"
    assert "as no name says" in " ".join(note.found for note in robot_notes(found))


BAD = {
    "no mass": (
        "wren", r'<mass value="[^"]*"/>', '<mass value="0"/>',
        "wren.urdf: inertial: no link has a mass; the CoM needs them",
    ),
    "no limits": (
        "wren", r'(<joint name="left_knee".*?)<limit[^>]*>', r"\1",
        "wren.urdf: joint left_knee: has no <limit>; give lower, upper, effort and velocity",
    ),
    "no shapes": (
        "wren", r"<(visual|collision)>.*?</\1>", "",
        "wren.urdf: link left_sole: has no <collision> or <visual> shape, so its sole is not known",
    ),
    "one leg": (
        "wren", r'<link name="right_hip">.*?<link name="right_sole">.*?</joint>', "",
        "wren.urdf: has no feet: ",
    ),
    "feet that are points": (
        "nao", r'<box size="0.15 0.089 0.035"/>', '<sphere radius="0.02"/>',
        "nao.urdf: link l_ankle_link: its lowest shapes touch the floor in a point or an edge",
    ),
    "a mesh that is not there": (
        "nao", r'<box size="0.15 0.089 0.035"/>', '<mesh filename="package://nao/foot.stl"/>',
        "nao.urdf: link l_ankle_link: its mesh package://nao/foot.stl is not there, so its sole",
    ),
    "knees that do not bend": (
        "wren", r'lower="-0.03" upper="2.2"', 'lower="-0.03" upper="0.2"',
        "wren.urdf: joint left_knee: does not bend 0.3 rad backwards",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_what_is_missing_is_told(name: str, tmp_path: Path) -> None:
    robot, pattern, replacement, message = BAD[name]
    # Meshes are looked for next to the URDF's folder too, where those of other tests may lie.
    (folder := tmp_path / "description").mkdir()
    with pytest.raises(FileError) as error:
        draft_robot(edited(folder, robot, pattern, replacement), robot)
    assert message in str(error.value)


def test_motors_without_limits_are_told(tmp_path: Path) -> None:
    """They load, but nothing can be planned with them."""
    file = edited(
        tmp_path, "wren", r'(<joint name="left_knee".*?)effort="[^"]*"', r'\1effort="0"', count=1
    )
    told = " ".join(note.found for note in robot_notes(draft_robot(file, "wren")))
    assert "left_knee: effort or velocity limit of the URDF is 0" in told


@pytest.mark.parametrize("count", [2, 4])
def test_cells_in_the_feet_are_those_of_the_urdf(count: int, tmp_path: Path) -> None:
    robot = robots.load("wren", shod=False)
    places = np.array([[0.05, 0.02, 0.0], [0.05, -0.02, 0.0], [-0.04, 0.02, 0.0], [-0.04, 0, 0]])
    added = ""
    for side, foot in zip(("left", "right"), robot.feet, strict=True):
        frame = robot.model.frames[
            robot.model.getFrameId(f"{side}_sole", pin.FrameType.BODY)
        ].placement
        for index, place in enumerate(places[:count]):
            x, y, z = frame.actInv(foot.placement.act(place))
            name = f"{side}_FSR{index}"
            added += (
                f'<link name="{name}"/><joint name="{name}_joint" type="fixed">'
                f'<parent link="{side}_sole"/><child link="{name}"/>'
                f'<origin xyz="{x} {y} {z}"/></joint>'
            )
    file = edited(tmp_path, "wren", "</robot>", f"{added}</robot>")
    drafted = draft_robot(file, "wren")
    _, shoe = prove(drafted, robot_text(drafted, str(file)), shoe_text(drafted))
    if count < 3:
        assert drafted.own_cells is None
        assert shoe.height > 0.0
        return
    assert shoe.names[:4] == tuple(f"left/left_FSR{index}" for index in range(4))
    assert shoe.height == shoe.mass == 0.0
    for number in (0, 1):
        np.testing.assert_allclose(drafted.cells(number), places[:, :2], atol=1e-4)


def test_strong_motors_on_a_small_robot_sag_more_at_their_limits(tmp_path: Path) -> None:
    """Its gears are no stiffer for that."""
    strong = edited(tmp_path, "wren", r'effort="([0-9.]+)"', 'effort="20"')
    usual, found = draft("wren"), draft_robot(strong, "wren")
    assert small_deflection(found.strength).sag == 0.3
    weaker, stronger = (small_deflection(strength) for strength in (0.1, 0.4))
    assert weaker == Robot.deflection
    assert stronger == JointDeflection(sag=0.06, play=weaker.play)
    assert 0.1 < usual.strength < 0.4
