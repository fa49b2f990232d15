"""Robot files and URDFs: what they say, and what is refused."""

from __future__ import annotations

import math
import re
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import shapely
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from core.robot import robots
from core.shoe import mutations, shoes
from core.shoe.mutations import DELETE, Key
from shoecal_core.errors import FileError, ShoecalError, VersionError
from shoecal_core.files import sha256
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import JointDeflection, Robot
from shoecal_core.robot.robot_file import load_robot

ODD, ODD_URDF = robots.FILES["odd_biped"], robots.FILES["odd_biped"].with_suffix(".urdf")
NAO, NAO_URDF = robots.FILES["nao"], robots.FILES["nao"].with_suffix(".urdf")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of both robots to spoil."""
    for path in (ODD, ODD_URDF, NAO, NAO_URDF):
        shutil.copy(path, tmp_path)
    return tmp_path


def respelled(folder: Path, pattern: str, new: str) -> Path:
    """Replace the first match in the odd biped's URDF; the robot file's path."""
    urdf = folder / ODD_URDF.name
    text, count = re.subn(pattern, new, urdf.read_text(), count=1, flags=re.DOTALL)
    assert count == 1
    urdf.write_text(text)
    return folder / ODD.name


# ---- good files -------------------------------------------------------------------------------


@pytest.mark.parametrize("name", robots.NAMES)
def test_the_file_is_what_the_robot_is(name: str) -> None:
    path = robots.FILES[name]
    raw = yaml.safe_load(path.read_text())
    robot = robots.load(name, shod=False)
    assert robot.name == raw["name"] == name
    assert (robot.path, robot.urdf) == (path, path.with_suffix(".urdf"))
    assert (robot.digest, robot.urdf_digest) == (sha256(path), sha256(robot.urdf))
    assert (robot.mass, robot.mass_std) == (raw["weight"]["mass_kg"], raw["weight"]["std_kg"])
    assert list(robot.leg_names) == raw["legs"]
    assert robot.optional == set(raw.get("optional_joints", []))
    for key, value in raw["posture_rad"].items():
        assert robot.posture[robot.joint(key)] == value
    for foot, side in zip(robot.feet, ("left", "right"), strict=True):
        for found, key in (
            (foot.outline, "outline_m"),
            (foot.sensing_polygon, "sensing_polygon_m"),
        ):
            assert {tuple(p) for p in found} == {tuple(p) for p in raw["feet"][side][key]}
            assert shapely.Polygon(found).exterior.is_ccw
    assert [capsule.name for capsule in robot.capsules] == [c["name"] for c in raw["capsules"]]
    for (a, b), pair in zip(robot.collision_pairs, raw["collision_pairs"], strict=True):
        assert (robot.capsules[a].name, robot.capsules[b].name) == (pair["a"], pair["b"])
    span = robot.support_range
    axes = [raw["support_range"][key] for key in ("dx_m", "dy_m", "dtheta_rad")]
    for field in ("lower", "upper", "step", "neutral"):
        assert getattr(span, field).tolist() == [axis[field] for axis in axes]


def test_shoes_add_their_mass_and_lift_the_robot() -> None:
    shoe = shoes.shoe("odd_shoe")
    bare, shod = robots.load("odd_biped", shod=False), robots.load("odd_biped")
    assert shod.mass == pytest.approx(bare.mass + shoe.mass)
    assert shod.mass_std == bare.mass_std
    for before, after in zip(bare.feet, shod.feet, strict=True):
        moved = before.placement.inverse() * after.placement
        np.testing.assert_allclose(moved.translation, [0.0, 0.0, -shoe.height], atol=1e-15)
        np.testing.assert_allclose(moved.rotation, np.eye(3), atol=1e-15)


def test_capsules_ride_on_the_joint_of_their_link() -> None:
    robot = robots.load("nao", shod=False)
    raw = yaml.safe_load(NAO.read_text())["capsules"]
    model = pin.buildModelFromUrdf(str(NAO_URDF), pin.JointModelFreeFlyer())
    data = model.createData()
    angles = robots.random_angles(robot, 1, seed=2)[0]
    pin.framesForwardKinematics(model, data, np.concatenate(([0, 0, 0, 0, 0, 0, 1], angles)))
    for capsule, item in zip(robot.capsules, raw, strict=True):
        link = data.oMf[model.getFrameId(item["link"], pin.FrameType.BODY)]
        for found, key in ((capsule.start, "from_m"), (capsule.end, "to_m")):
            np.testing.assert_allclose(
                data.oMi[capsule.joint].act(found), link.act(np.array(item[key], float)), atol=1e-12
            )
        assert capsule.radius == item["radius_m"]


def test_clockwise_polygons_are_turned_round(folder: Path) -> None:
    place: tuple[Key, ...] = ("feet", "left", "outline_m")
    corners = yaml.safe_load(ODD.read_text())["feet"]["left"]["outline_m"]
    for points in (corners, corners[::-1]):
        path = mutations.write_edited(folder / ODD.name, ODD, (place, points))
        outline = load_robot(path).feet[0].outline
        assert shapely.Polygon(outline).exterior.is_ccw


def test_another_urdf_may_be_given(folder: Path) -> None:
    other = (folder / ODD_URDF.name).rename(folder / "copy.urdf")
    robot = load_robot(folder / ODD.name, urdf=other)
    assert robot.urdf == other
    assert "odd_biped.urdf" in str(
        mutations.refused(folder / ODD.name, lambda: load_robot(folder / ODD.name))
    )


def test_sliding_joints_and_skew_axes_are_pinocchio_s_too(folder: Path) -> None:
    path = respelled(
        folder,
        'name="waist_pitch" type="revolute">(.*?)<origin [^>]*>(.*?)<axis xyz="0 1 0"/>',
        r'name="waist_pitch" type="prismatic">\1<origin xyz="0.1 0 0.2" rpy="0.3 -0.2 0.1"/>\2'
        r'<axis xyz="1 2 -3"/>',
    )
    respelled(
        folder,
        'name="left_shoulder"(.*?)<axis xyz="0 1 0"/>',
        r'name="left_shoulder"\1<axis xyz="1 -1 0.5"/>',
    )
    robot = load_robot(path)
    kinematics = Kinematics(robot)
    data = robot.model.createData()
    for row in robots.random_angles(robot, 5):
        com = pin.centerOfMass(robot.model, data, np.concatenate(([0, 0, 0, 0, 0, 0, 1], row)))
        np.testing.assert_allclose(kinematics.states(row[None]).com_in_base[0], com, atol=1e-12)


def test_a_link_and_a_joint_of_one_name(folder: Path) -> None:
    """Names are looked up by kind: the copy stands as the original does."""
    text = (folder / ODD_URDF.name).read_text()
    (folder / ODD_URDF.name).write_text(text.replace('"left_knee"', '"left_ankle_roll_body"'))
    robot_text = (folder / ODD.name).read_text().replace("left_knee\n", "left_ankle_roll_body\n")
    (folder / ODD.name).write_text(robot_text.replace("left_knee:", "left_ankle_roll_body:"))
    same, original = load_robot(folder / ODD.name), robots.load("odd_biped", shod=False)
    angles = robots.random_angles(original, 3)
    np.testing.assert_allclose(
        Kinematics(same).states(angles).com,
        robots.kinematics("odd_biped", shod=False).states(angles).com,
        atol=1e-12,
    )


# ---- bad robot files --------------------------------------------------------------------------

LEFT: tuple[Key, ...] = ("feet", "left")
DX: tuple[Key, ...] = ("support_range", "dx_m")
CAPSULE: tuple[Key, ...] = ("capsules", 1)
BAD: dict[str, tuple[tuple[Key, ...], object, str, str]] = {
    "no name": (("name",), DELETE, "name", "is missing"),
    "no URDF": (("urdf",), DELETE, "urdf", "is missing"),
    "a key too many": (("colour",), "red", "colour", "unknown key"),
    "no weight": (("weight",), DELETE, "weight", "is missing"),
    "a weight of zero": (("weight", "mass_kg"), 0, "weight.mass_kg", "above 0"),
    "a negative weight": (("weight", "mass_kg"), -5, "weight.mass_kg", "above 0"),
    "a weight of text": (("weight", "mass_kg"), "5 kg", "weight.mass_kg", "expected a number"),
    "a weight without end": (("weight", "mass_kg"), math.inf, "weight.mass_kg", "finite"),
    "a weight in pounds": (("weight", "mass_lb"), 5, "weight.mass_lb", "unknown key"),
    "an uncertainty below zero": (("weight", "std_kg"), -1, "weight.std_kg", "at least 0"),
    "no uncertainty": (("weight", "std_kg"), DELETE, "weight.std_kg", "is missing"),
    "no feet": (("feet",), DELETE, "feet", "is missing"),
    "one foot": (("feet", "right"), DELETE, "feet.right", "is missing"),
    "a third foot": (("feet", "tail"), {}, "feet.tail", "unknown key"),
    "a foot on no link": ((*LEFT, "link"), "left_fot", "feet.left.link", "no link 'left_fot'"),
    "a foot on a joint": ((*LEFT, "link"), "left_knee", "feet.left.link", "no link 'left_knee'"),
    "both feet one link": (
        ("feet", "right", "link"), "left_ankle_roll_body", "feet.right.link", "the left foot's"
    ),
    "a sole without a place": (
        (*LEFT, "sole_xyz_m"), DELETE, "feet.left.sole_xyz_m", "is missing"
    ),
    "a sole in a plane": ((*LEFT, "sole_xyz_m"), [0, 0], "feet.left.sole_xyz_m", "3 numbers"),
    "a sole turned nowhere": (
        (*LEFT, "sole_rpy_rad"), [0, 0, math.nan], "feet.left.sole_rpy_rad", "finite"
    ),
    "an outline of two corners": (
        (*LEFT, "outline_m"), [[0, 0], [1, 1]], "feet.left.outline_m", "three corners"
    ),
    "an outline of no corners": ((*LEFT, "outline_m"), [], "feet.left.outline_m", "n x 2"),
    "an outline without area": (
        (*LEFT, "outline_m"), [[0, 0], [1, 1], [2, 2]], "feet.left.outline_m", "no area"
    ),
    "an outline that crosses itself": (
        (*LEFT, "outline_m"),
        lambda points: [points[0], points[2], points[1], points[3]],
        "feet.left.outline_m",
        "crosses itself",
    ),
    "an outline with a dent": (
        (*LEFT, "outline_m"),
        lambda points: [*points, [0.0, 0.0]],
        "feet.left.outline_m",
        "not convex",
    ),
    "an outline in millimetres": (
        (*LEFT, "outline_m"),
        lambda points: [[1e3 * x, 1e3 * y] for x, y in points],
        "feet.left.outline_m",
        "give metres",
    ),
    "a sensing polygon with a dent": (
        (*LEFT, "sensing_polygon_m"),
        lambda points: [*points, [0.0, 0.0]],
        "feet.left.sensing_polygon_m",
        "not convex",
    ),
    "a sole that faces forward": (
        (*LEFT, "sole_rpy_rad"), [0, 1.57, 0], "feet.left.sole_rpy_rad", "z points up"
    ),
    "feet that overlap": (
        ("feet", "right", "outline_m"),
        lambda points: [[x, 2.0 * y] for x, y in points],
        "support_range.dy_m.neutral",
        "overlap at dx 0 m, dy -0.12 m",
    ),
    "feet that overlap in the posture": (
        ("posture_rad", "left_hip_roll"), -0.2, "posture_rad", "overlap in this posture"
    ),
    "a sole whose x axis points to its heel": (
        (*LEFT, "sole_rpy_rad"), [0, 0, 3.1416], "feet", "x axes of the soles point apart (left at "
    ),
    "a sensing polygon outside": (
        (*LEFT, "sensing_polygon_m"),
        lambda points: [[2 * x, y] for x, y in points],
        "feet.left.sensing_polygon_m",
        "outside 'outline_m'",
    ),
    "a corner in three dimensions": (
        (*LEFT, "outline_m", 0), [0, 0, 0], "feet.left.outline_m", "rows of equal length"
    ),
    "no legs": (("legs",), DELETE, "legs", "0 joints"),
    "legs without a name": (("legs", 0), 5, "legs", "list of names"),
    "a leg that is not there": (("legs", 0), "left_tail", "legs", "no joint 'left_tail'"),
    "a leg twice": (("legs", 1), "left_hip_yaw", "legs", "must stand once"),
    "too few legs": (("legs",), lambda legs: legs[:5], "legs", "5 joints cannot"),
    "legs that do not reach a foot": (
        ("legs",),
        lambda legs: [*legs[:6], "waist_pitch"],
        "legs",
        "none of them moves the right foot; name its leg's: right_hip_yaw, ",
    ),
    "an optional joint that is not there": (
        ("optional_joints",), ["left_ear"], "optional_joints", "no joint 'left_ear'"
    ),
    "an optional joint between the feet": (
        ("optional_joints",), ["left_knee"], "optional_joints", "'left_knee' lies between the feet"
    ),
    "a shared motor of no joint": (
        ("shared_motors",), [{"joint": "x", "leader": "left_knee", "ratio": 1}],
        "shared_motors[0].joint", "'x' is not one of",
    ),
    "a shared motor without a ratio": (
        ("shared_motors",), [{"joint": "right_shoulder", "leader": "left_shoulder"}],
        "shared_motors[0].ratio", "is missing",
    ),
    "a leg that follows": (
        ("shared_motors",), [{"joint": "right_knee", "leader": "left_knee", "ratio": 1}],
        "legs", "'right_knee' turns with 'left_knee'; leave it out",
    ),
    "a shared motor that turns nothing": (
        ("shared_motors",),
        [{"joint": "right_shoulder", "leader": "left_shoulder", "ratio": 0}],
        "shared_motors[0].ratio",
        "never turns",
    ),
    "a joint that follows itself": (
        ("shared_motors",), [{"joint": "waist_pitch", "leader": "waist_pitch", "ratio": 1}],
        "shared_motors", "must follow one joint",
    ),
    "a joint that follows two": (
        ("shared_motors",),
        [
            {"joint": "waist_pitch", "leader": "left_shoulder", "ratio": 1},
            {"joint": "waist_pitch", "leader": "right_shoulder", "ratio": 1},
        ],
        "shared_motors",
        "must follow one joint",
    ),
    "a chain of followers": (
        ("shared_motors",),
        [
            {"joint": "waist_pitch", "leader": "left_shoulder", "ratio": 1},
            {"joint": "left_shoulder", "leader": "right_shoulder", "ratio": 1},
        ],
        "shared_motors",
        "must follow one joint",
    ),
    "no posture": (("posture_rad",), DELETE, "posture_rad", "is missing"),
    "a posture of no joint": (
        ("posture_rad", "left_ear"), 0, "posture_rad.left_ear", "no joint 'left_ear'"
    ),
    "a joint that is mistyped": (
        ("posture_rad", "left_kne"), 0, "posture_rad.left_kne", "did you mean 'left_knee'?"
    ),
    "a posture beyond its joint": (
        ("posture_rad", "left_knee"), 9.0, "posture_rad.left_knee", "outside the joint's"
    ),
    "no range": (("support_range",), DELETE, "support_range", "is missing"),
    "a range without an axis": (DX, DELETE, "support_range.dx_m", "is missing"),
    "a range of too many places": (
        (*DX, "step"), 1e-7, "support_range.dx_m.step", "enlarge the step"
    ),
    "a crossed range": ((*DX, "lower"), 1.0, "support_range.dx_m.lower", "above 'upper'"),
    "a step of zero": ((*DX, "step"), 0, "support_range.dx_m.step", "above 0"),
    "a neutral stance out of range": (
        (*DX, "neutral"), 0.2, "support_range.dx_m.neutral", "at most 0.06"
    ),
    "a range in degrees": (
        ("support_range", "dtheta_deg"), {}, "support_range.dtheta_deg", "unknown key"
    ),
    "a capsule on no link": ((*CAPSULE, "link"), "x", "capsules[1].link", "no link 'x'"),
    "a capsule without radius": (
        (*CAPSULE, "radius_m"), 0, "capsules[1].radius_m", "above 0"
    ),
    "a capsule of negative radius": (
        (*CAPSULE, "radius_m"), -0.04, "capsules[1].radius_m", "above 0"
    ),
    "a capsule in millimetres": (
        (*CAPSULE, "radius_m"), 40, "capsules[1].radius_m", "at most 1"
    ),
    "a capsule with one end": ((*CAPSULE, "to_m"), DELETE, "capsules[1].to_m", "is missing"),
    "a capsule twice": ((*CAPSULE, "name"), "left_thigh", "capsules[1].name", "twice"),
    "a pair with a stranger": (
        ("collision_pairs", 0, "b"), "x", "collision_pairs[0].b", "'x' is not one of"
    ),
    "a pair that moves together": (
        ("capsules", 3, "link"), "left_hip_pitch_body", "collision_pairs[0].b", "drop the pair"
    ),
    "a pair with itself": (
        ("collision_pairs", 0, "b"), "left_thigh", "collision_pairs[0].b", "to itself"
    ),
    "a URDF that is a number": (("urdf",), 5, "urdf", "expected text"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_each_fault_is_one_error_that_names_its_field(name: str, folder: Path) -> None:
    place, value, field, problem = BAD[name]
    path = mutations.write_edited(folder / ODD.name, ODD, (place, value))
    error = mutations.refused(path, lambda: load_robot(path, shoes.shoe("odd_shoe")))
    assert error.field == field
    assert problem in error.problem


def test_a_newer_format_is_refused(folder: Path) -> None:
    path = mutations.write_edited(folder / ODD.name, ODD, (("format",), 2))
    with pytest.raises(VersionError, match="update shoecal"):
        load_robot(path)


def test_the_nao_s_follower_is_no_leg(folder: Path) -> None:
    def add(legs: list[str]) -> list[str]:
        return [*legs, "RHipYawPitch"]

    path = mutations.write_edited(folder / NAO.name, NAO, (("legs",), add))
    assert mutations.refused(path, lambda: load_robot(path)).field == "legs"


def test_a_posture_against_the_motor(folder: Path) -> None:
    path = mutations.write_edited(folder / NAO.name, NAO, (("posture_rad", "RHipYawPitch"), -0.1))
    error = mutations.refused(path, lambda: load_robot(path))
    assert error.field == "posture_rad.RHipYawPitch"
    assert "turns with 'LHipYawPitch', so it is 0 rad" in error.problem


# ---- joints that mimic ------------------------------------------------------------------------


def mimicking(folder: Path, joint: str, mimic: str) -> Path:
    """The odd biped with a <mimic> in one joint; the robot file's path."""
    return respelled(folder, f'(joint name="{joint}".*?)</joint>', rf"\1<mimic {mimic}/></joint>")


def test_what_the_urdf_says_of_shared_motors_is_read(folder: Path) -> None:
    path = mimicking(folder, "right_shoulder", 'joint="left_shoulder" multiplier="-0.5"')
    (motor,) = load_robot(path).shared
    names = robots.load("odd_biped").joint_names
    assert names[motor.joint] == "right_shoulder"
    assert (names[motor.leader], motor.ratio) == ("left_shoulder", -0.5)
    posture: tuple[Key, ...] = ("posture_rad", "left_shoulder")
    robot = load_robot(mutations.write_edited(path, ODD, (posture, 0.4)))
    assert robot.posture[robot.joint("right_shoulder")] == pytest.approx(-0.2)


def test_the_nao_s_urdf_and_its_robot_file_agree(folder: Path) -> None:
    path = mutations.write_edited(folder / NAO.name, NAO, (("shared_motors",), DELETE))
    assert load_robot(path).shared == robots.load("nao").shared
    other = mutations.write_edited(folder / NAO.name, NAO, (("shared_motors", 0, "ratio"), -1.0))
    error = mutations.refused(other, lambda: load_robot(other))
    assert error.field == "shared_motors"
    assert "'LHipYawPitch', 1); make them agree" in error.problem


BAD_MIMICS = {
    "nobody": ("right_shoulder", 'joint="nobody"', "no other moving joint"),
    "itself": ("right_shoulder", 'joint="right_shoulder"', "no other moving joint"),
    "an offset": ("right_shoulder", 'joint="left_shoulder" offset="0.1"', "offset 0.1"),
    "no ratio": ("right_shoulder", 'joint="left_shoulder" multiplier="0"', "multiplier 0"),
    "text": ("right_shoulder", 'joint="left_shoulder" multiplier="two"', '"two" of its <mimic>'),
}


@pytest.mark.parametrize("name", BAD_MIMICS)
def test_what_cannot_be_mimicked(name: str, folder: Path) -> None:
    joint, mimic, problem = BAD_MIMICS[name]
    path = mimicking(folder, joint, mimic)
    error = mutations.refused(folder / ODD_URDF.name, lambda: load_robot(path))
    assert error.field == f"joint {joint}"
    assert problem in error.problem


def test_a_joint_that_mimics_a_follower(folder: Path) -> None:
    mimicking(folder, "waist_pitch", 'joint="left_shoulder"')
    path = mimicking(folder, "left_shoulder", 'joint="right_shoulder"')
    error = mutations.refused(folder / ODD_URDF.name, lambda: load_robot(path))
    assert error.field == "joint waist_pitch"
    assert "follows another joint itself" in error.problem


# ---- bad URDFs --------------------------------------------------------------------------------

CHEST = '<mass value="2.6"/>'
WAIST = r'<limit lower="-0.5" upper="0.8" effort="12" velocity="5"/>'
BAD_URDF = {
    "no URDF": (r".*", "hello", "", "no <robot> element"),
    "half of a file": (r"(.{3000}).*", r"\1", "", "not valid XML"),
    "nothing but a robot": (r".*", "<robot name='a'></robot>", "", "not a usable URDF"),
    "a zero byte": (r"<joint", "\x00<joint", "", "not valid XML"),
    "a document type": (
        r'<\?xml version="1.0"\?>', "<!DOCTYPE a [<!ENTITY b 'c'>]>", "", "document type"
    ),
    "no masses": (r".*", "<robot name='a'><link name='b'/></robot>", "inertial", "no link has"),
    "a negative mass": (CHEST, '<mass value="-2.6"/>', "link chest", "'-2.6' is not a number"),
    "a mass that is none": (CHEST, '<mass value="nan"/>', "link chest", "'nan' is not a number"),
    "a mass without end": (CHEST, '<mass value="inf"/>', "link chest", "'inf' is not a number"),
    "a mass beyond reason": (CHEST, '<mass value="1e308"/>', "link chest", "is not a number"),
    "a mass of text": (CHEST, '<mass value="2,6"/>', "link chest", "'2,6' is not a number"),
    "a mass left out": (CHEST, "<mass/>", "link chest", "'' is not a number"),
    "no mass in an inertial": (CHEST, "", "inertial", "no <mass> in the <inertial> of link chest;"),
    "an inertial with nothing in it": (
        r".*", "<robot name='a'><link name='b'><inertial/></link></robot>", "inertial", "(link b)"
    ),
    "two bodies apart": (
        "</robot>", "<link name='odd'/></robot>", "", "Two root links found: [base_link] and [odd]"
    ),
    "an inertia beyond reason": (
        'izz="[^"]*"', 'izz="1e308"', "link base_link", 'izz="1e308" is not a moment of inertia'
    ),
    "a mass beyond reach": (
        'xyz="0.01 0 0.09"', 'xyz="-1e308 0 0.09"', "link chest", "in <inertial> is farther than"
    ),
    "a joint beyond reach": (
        r'(<joint name="waist_pitch".*?xyz=")[^"]*', r"\g<1>0 2000 0", "joint waist_pitch",
        'xyz="0 2000 0" of its <origin> is farther than 1000 m; give metres',
    ),
    "an inertial the parser drops": (
        'xyz="0.01 0 0.09"', 'xyz="nan 0 0.09"', "link chest", "is not three numbers; give three"
    ),
    "a CoM of two numbers": (
        'xyz="0.01 0 0.09"', 'xyz="0.01 0.09"', "link chest",
        'xyz="0.01 0.09" of its <origin> in <inertial> is not three numbers; give three, in m',
    ),
    "a joint turned by degrees": (
        r'(<joint name="waist_pitch".*?rpy=")[^"]*', r"\g<1>90 0 0", "joint waist_pitch",
        'rpy="90 0 0" of its <origin> is more than a turn: in degrees? Give rad',
    ),
    "a body that hangs on itself": (
        '<parent link="base_link"/>\n    <child link="chest"/>',
        '<parent link="chest"/>\n    <child link="chest"/>',
        "inertial",
        "every link hangs on the base",
    ),
    "a body in a circle": (
        '<parent link="base_link"/>\n    <child link="chest"/>',
        '<parent link="left_arm"/>\n    <child link="chest"/>',
        "inertial",
        "every link hangs on the base",
    ),
    "an unknown parent": (
        '<parent link="base_link"/>', '<parent link="nobody"/>', "", "not a usable URDF"
    ),
    "a joint twice": ('joint name="left_shoulder"', 'joint name="waist_pitch"', "", "not a usable"),
    "a link twice": ('link name="left_arm"', 'link name="chest"', "", "not a usable URDF"),
    "crossed limits": (
        'lower="-0.5" upper="0.8"', 'lower="0.8" upper="-0.5"', "joint waist_pitch", "crossed"
    ),
    "a limit that is none": (
        'upper="0.8"', 'upper="nan"', "joint waist_pitch", 'upper="nan" of its <limit> is not'
    ),
    "no limits": (WAIST, "", "joint waist_pitch", "has no <limit>; give lower, upper, effort"),
    "no effort limit": (
        'effort="12"', "", "joint waist_pitch", 'effort="" of its <limit> is not a number'
    ),
    "no velocity limit": (
        'effort="12" velocity="5"', 'effort="12"', "joint waist_pitch", 'velocity="" of its'
    ),
    "an endless velocity": (
        'effort="12" velocity="5"', 'effort="12" velocity="inf"', "joint waist_pitch", '"inf"'
    ),
    "a negative effort": (
        'effort="12"', 'effort="-12"', "joint waist_pitch", "is not a number of zero or more"
    ),
    "one position limit": (
        'lower="-0.5" upper="0.8"', 'lower="0.8"', "joint waist_pitch", "missing or crossed"
    ),
    "a floating joint": (
        'type="revolute"', 'type="floating"', "joint waist_pitch", "only revolute"
    ),
    "a planar joint": ('type="revolute"', 'type="planar"', "joint waist_pitch", "only revolute"),
    "a joint of no kind": ('type="revolute"', 'type="wobbly"', "", "not a usable URDF"),
    "an axis without direction": (
        'axis xyz="0 1 0"', 'axis xyz="0 0 0"', "joint waist_pitch", "no direction"
    ),
    "an axis that is none": ('axis xyz="0 1 0"', 'axis xyz="nan 1 0"', "", "not a usable URDF"),
    "a joint nowhere": ('xyz="0 0 0.06"', 'xyz="0 0 inf"', "joint waist_pitch", "not three"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_URDF)
def test_each_fault_of_a_urdf_is_one_error(name: str, folder: Path) -> None:
    pattern, new, field, problem = BAD_URDF[name]
    path = respelled(folder, pattern, new)
    error = mutations.refused(folder / ODD_URDF.name, lambda: load_robot(path))
    assert error.field == field
    assert problem in error.problem


def test_a_urdf_of_endless_depth_is_refused_before_it_is_understood(folder: Path) -> None:
    deep = 200_000
    path = respelled(folder, "</robot>", "<a>" * deep + "</a>" * deep + "</robot>")
    error = mutations.refused(folder / ODD_URDF.name, lambda: load_robot(path))
    assert "<a> is within 100 other elements" in error.problem


def test_a_urdf_that_cannot_be_read(folder: Path) -> None:
    path = mutations.write_edited(folder / ODD.name, ODD, (("urdf",), "."))
    assert "directory" in mutations.refused(folder, lambda: load_robot(path)).problem
    path = mutations.write_edited(folder / ODD.name, ODD, (("urdf",), "none.urdf"))
    error = mutations.refused(path, lambda: load_robot(path))
    assert f"there is no URDF at {folder / 'none.urdf'}" in error.problem
    assert error.field == "urdf"


# ---- by chance --------------------------------------------------------------------------------


def check(load: Callable[[], Robot]) -> None:
    """A robot that can be computed with, or one of our errors."""
    try:
        robot = load()
    except ShoecalError:
        return
    masses = [inertia.mass for inertia in robot.model.inertias]
    assert sum(masses) == pytest.approx(robot.mass)
    assert min(masses) >= 0.0
    com = pin.centerOfMass(
        robot.model,
        robot.model.createData(),
        np.concatenate(([0, 0, 0, 0, 0, 0, 1], robot.posture)),
    )
    assert np.isfinite(com).all()
    assert (robot.lower < robot.upper).all()


@given(st.data())
@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])
def test_whatever_happens_to_the_robot_s_text(data: st.DataObject) -> None:
    text = data.draw(mutations.mutated(ODD.read_text()))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / ODD.name
        path.write_text(text, encoding="utf-8")
        check(lambda: load_robot(path, shoes.shoe("odd_shoe"), urdf=ODD_URDF))


@given(st.data())
@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])
def test_whatever_happens_to_the_urdf_s_text(data: st.DataObject) -> None:
    text = data.draw(mutations.mutated(ODD_URDF.read_text()))
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / ODD_URDF.name
        path.write_text(text, encoding="utf-8")
        check(lambda: load_robot(ODD, urdf=path))


def test_bytes_that_are_no_text(folder: Path) -> None:
    urdf = folder / ODD_URDF.name
    urdf.write_bytes(urdf.read_bytes().replace(b"made-up", b"\xff\xfe"))
    assert load_robot(folder / ODD.name).name == "odd_biped"
    urdf.write_bytes(b"\xff\xfe" + urdf.read_text(errors="replace").encode("utf-16-le"))
    with pytest.raises(FileError):
        load_robot(folder / ODD.name)


def test_friction_and_deflection(folder: Path) -> None:
    robot = load_robot(NAO)
    assert (robot.friction, robot.deflection) == (0.6, JointDeflection(sag=0.028, play=0.006))
    keys = ("friction", "joint_deflection")
    path = mutations.write_edited(folder / NAO.name, NAO, *(((key,), DELETE) for key in keys))
    robot = load_robot(path)
    assert (robot.friction, robot.deflection) == (0.5, JointDeflection())


@pytest.mark.parametrize(
    ("key", "value"),
    [
        (("friction",), 0.0),
        (("joint_deflection", "sag_rad"), 0.0),
        (("joint_deflection", "play_rad"), -0.001),
        (("joint_deflection", "slack"), 0.1),
    ],
)
def test_impossible_friction_and_deflection_are_refused(
    folder: Path, key: tuple[Key, ...], value: float
) -> None:
    path = mutations.write_edited(folder / NAO.name, NAO, (key, value))
    assert mutations.refused(path, lambda: load_robot(path)).field == ".".join(map(str, key))


def test_a_leg_joint_that_is_fixed_is_told_so(folder: Path) -> None:
    """Not that the URDF has none of that name."""
    path = respelled(folder, '(name="left_hip_yaw" type=)"revolute"', r'\1"fixed"')
    error = mutations.refused(path, lambda: load_robot(path))
    assert (error.field, "joint 'left_hip_yaw' is fixed in the URDF" in error.problem) == (
        "legs",
        True,
    )
