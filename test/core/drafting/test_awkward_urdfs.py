"""Features of published URDFs that no two makers write alike, each on a robot that is known."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from core.drafting.drafts import ROBOTS, draft, edited
from shoecal_core.cli import main
from shoecal_core.drafting.draft import Draft, draft_robot, prove
from shoecal_core.drafting.notes import robot_notes, shoe_notes
from shoecal_core.drafting.soles import SoleSize, find_sole
from shoecal_core.drafting.text import robot_text, shoe_text
from shoecal_core.errors import FileError
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.urdf import move_zero, read_urdf, with_joints_plain

FINGER = """<link name="{0}"><inertial><mass value="1e-6"/><inertia ixx="1e-9" ixy="0" ixz="0"
    iyy="1e-9" iyz="0" izz="1e-9"/></inertial></link>
    <joint name="{0}" type="continuous"><parent link="{1}"/><child link="{0}"/>
    <axis xyz="0 0 1"/>{2}</joint>"""
MOUNT = """<link name="{0}_body"/><joint name="{0}" type="fixed"><parent link="{1}"/>
    <child link="{0}_body"/><origin xyz="{2}" rpy="0 -1.5707963267948966 0"/></joint>"""
DECLARED = """<gazebo reference="{0}"><sensor name="s" type="force_torque"><pose>{1}</pose>
    </sensor></gazebo><sensor name="s" type="force_torque"><parent joint="{0}"/>
    <origin xyz="0 0 0" rpy="0 0 0"/></sensor>"""
NO_SHAPES = r"<(visual|collision)>.*?</\1>"
STILL = "0 0 0 0 0 0"


def with_more(folder: Path, more: str) -> Path:
    """The known robot with more links and joints."""
    return edited(folder, "wren", "</robot>", f"{more}</robot>")


def with_meshes(folder: Path, part: str) -> Path:
    """The known robot with meshes that are not there for all shapes of one part of both legs."""
    urdf = folder / "wren.urdf"
    text = (ROBOTS / "wren.urdf").read_text()
    for side in ("left", "right"):
        mesh = f'<geometry><mesh filename="package://wren_meshes/{side}.stl"/></geometry>'
        start = text.index(f'<link name="{side}_{part}">')
        end = text.index("</link>", start)
        link = re.sub("<geometry>.*?</geometry>", mesh, text[start:end], flags=re.DOTALL)
        text = text[:start] + link + text[end:]
    urdf.write_text(text)
    return urdf


def slid(folder: Path, along_m: dict[str, float]) -> Path:
    """The known robot, frames of some joints that far along their own axes; all else in place."""
    tree = ElementTree.parse(ROBOTS / "wren.urdf")
    root = tree.getroot()
    for name, distance in along_m.items():
        joint = next(one for one in root.iter("joint") if one.get("name") == name)
        link = next(one.get("link", "") for one in joint.iter("child"))
        for element in root:
            if element is joint:
                moved(next(element.iter("origin")), distance, turned=True)
            elif element.get("name") == link and element.tag == "link":
                for origin in element.iter("origin"):
                    moved(origin, -distance, turned=False)
            elif element.tag == "joint" and next(element.iter("parent")).get("link") == link:
                moved(next(element.iter("origin")), -distance, turned=False)
    urdf = folder / "wren.urdf"
    tree.write(urdf)
    return urdf


def moved(origin: ElementTree.Element, distance: float, *, turned: bool) -> None:
    """An origin moved along the z axis, its own or the frame's that it is in."""
    rpy = np.array([float(one) for one in origin.get("rpy", "0 0 0").split()])
    way = (pin.rpy.rpyToMatrix(rpy) if turned else np.eye(3))[:, 2]
    place = np.array([float(one) for one in origin.get("xyz", "0 0 0").split()])
    origin.set("xyz", " ".join(f"{one:.12f}" for one in place + distance * way))


def drafted(urdf: Path) -> Draft:
    """A draft that loads."""
    found = draft_robot(urdf, "wren")
    prove(found, robot_text(found, urdf.name), shoe_text(found))
    return found


def told(found: Draft) -> str:
    return " ".join(note.found for note in (*robot_notes(found), *shoe_notes(found)))


def sitting(folder: Path) -> tuple[Path, dict[str, float]]:
    """The known robot, legs forward in its zero pose; and its angles there before, by joint."""
    root = ElementTree.parse(ROBOTS / "wren.urdf").getroot()
    posture = draft("wren").posture
    hips = ("left_hip_swing", "right_hip_swing")
    bent = {hip: float(np.copysign(2.0, posture[hip])) for hip in hips}
    for joint in root.iter("joint"):
        if angle := bent.get(joint.get("name", ""), 0.0):
            move_zero(joint, angle)
            limit = next(joint.iter("limit"))
            for end in ("lower", "upper"):
                limit.set(end, str(float(limit.get(end, "")) - angle))
    urdf = folder / "wren.urdf"
    ElementTree.ElementTree(root).write(urdf)
    return urdf, bent


def test_a_keyframe_stands_where_the_zero_pose_does_not(tmp_path: Path) -> None:
    """With knees bent it is the start; with straight ones they are bent from there."""
    urdf, bent = sitting(tmp_path)
    with pytest.raises(FileError, match="has no feet") as sat:
        draft_robot(urdf, "wren")
    usual = draft("wren")
    standing = {name: angle - bent.get(name, 0.0) for name, angle in usual.posture.items()}
    straight = {name: -angle for name, angle in bent.items()}
    for name, angles in (("home", standing | {"head_pan": 0.2}), ("straight", straight)):
        found = draft_robot(urdf, "wren", keyframes={"seat": {"head_pan": 0.1}, name: angles})
        prove(found, robot_text(found, urdf.name), shoe_text(found))
        assert f"keyframe {name}" in told(found)
        assert found.posture.pop("head_pan", 0.0) == (0.2 if name == "home" else 0.0)
        before = {one: angle + bent.get(one, 0.0) for one, angle in found.posture.items()}
        assert before == pytest.approx(usual.posture, abs=2e-3)
    with pytest.raises(FileError, match=re.escape(sat.value.problem)):
        draft_robot(urdf, "wren", keyframes={"seat": {"head_pan": 0.1}})


LOOP = '<loop_joint name="rod"><link1 link="{}"/><link2 link="{}"/></loop_joint>'


def test_closed_chains_outside_the_legs_are_held(tmp_path: Path) -> None:
    """A rod from the shoulder to the forearm: a driver need not report what it holds."""
    rod = FINGER.format("rod", "left_shoulder", "")
    urdf = with_more(tmp_path, rod + LOOP.format("rod", "left_forearm"))
    found = drafted(urdf)
    held = ("left_arm_lift", "left_elbow", "rod")
    assert set(found.held) == set(held)
    assert f"{', '.join(found.held)}: of closed chains" in told(found)
    (tmp_path / "wren.yaml").write_text(robot_text(found, urdf.name))
    robot = load_robot(tmp_path / "wren.yaml")
    assert robot.optional == set(held)
    others = [index for index, name in enumerate(robot.joint_names) if name not in held]
    reported = [robot.joint_names[index] for index in others]
    angles = robot.from_measured(reported, robot.posture[others])
    np.testing.assert_array_equal(angles, robot.posture)


@pytest.mark.parametrize(
    ("ends", "field", "why"),
    [
        (("left_hip", "left_sole"), "legs: joints left_hip_sway, left_hip_swing", "(rod) go"),
        (("left_hip", "left_sol"), "loop_joint rod", "no link has the name 'left_sol'"),
    ],
)
def test_closed_chains_across_a_leg_are_refused(
    ends: tuple[str, str], field: str, why: str, tmp_path: Path
) -> None:
    with pytest.raises(FileError) as raised:
        draft_robot(with_more(tmp_path, LOOP.format(*ends)), "wren")
    assert raised.value.field.startswith(field)
    assert why in raised.value.problem


def test_a_link_that_hangs_on_two_joints_is_named(tmp_path: Path) -> None:
    rod = """<joint name="rod" type="fixed"><parent link="left_hip"/>
        <child link="right_sole"/></joint>"""
    with pytest.raises(FileError, match="right_ankle_sway and rod") as raised:
        draft_robot(with_more(tmp_path, rod), "wren")
    assert raised.value.field == "link right_sole"


def test_joints_without_limits_and_followers(tmp_path: Path) -> None:
    """A hand that turns for ever, fingers without masses to speak of that follow it."""
    mimic = '<mimic joint="hand" multiplier="0.9" offset="0"/>'
    hand = FINGER.format("hand", "left_forearm", "")
    urdf = with_more(tmp_path, hand + FINGER.format("finger", "hand", mimic))
    found = drafted(urdf)
    assert found.leg_names == draft("wren").leg_names
    (tmp_path / "wren.yaml").write_text(robot_text(found, urdf.name))
    robot = load_robot(tmp_path / "wren.yaml")
    place = robot.joint_names.index("hand")
    assert (robot.lower[place], robot.upper[place]) == (-np.pi, np.pi)
    assert [robot.joint_names[motor.joint] for motor in robot.shared] == ["finger"]
    assert "continuous" not in told(found)


@pytest.mark.parametrize(
    ("angle", "kind"), [(0.0, "revolute"), (0.4, "revolute"), (0.02, "prismatic")]
)
def test_joints_that_equal_limits_lock(angle: float, kind: str, tmp_path: Path) -> None:
    """Fixed where they are: the model, the draft and the simulator see one robot."""
    finger = """<link name="finger"><inertial><origin xyz="0.1 0 0"/><mass value="0.5"/>
        <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial></link>
        <joint name="finger" type="{0}"><parent link="left_forearm"/><child link="finger"/>
        <origin xyz="0 0.02 0" rpy="0.3 0 0.2"/><axis xyz="0 1 0"/>{1}</joint>"""
    limit = '<limit lower="{0}" upper="{1}" effort="1" velocity="1"/>'
    one, other = tmp_path / "locked", tmp_path / "free"
    one.mkdir()
    other.mkdir()
    locked = with_more(one, finger.format(kind, limit.format(angle, angle)))
    free = with_more(other, finger.format(kind, limit.format(-1.0, 1.0)))
    found = drafted(locked)
    assert "finger: both limits are one angle, so fixed at it." in told(found)
    model, free_model = read_urdf(locked).model, read_urdf(free).model
    assert not model.existJointName("finger")
    bent = pin.neutral(free_model)
    bent[free_model.joints[free_model.getJointId("finger")].idx_q] = angle
    np.testing.assert_allclose(
        pin.centerOfMass(model, model.createData(), pin.neutral(model)),
        pin.centerOfMass(free_model, free_model.createData(), bent),
        atol=1e-9,
    )
    spec = mujoco.MjSpec.from_string(with_joints_plain(locked.read_text()))
    assert spec.joint("finger") is None
    with pytest.raises(FileError, match="missing or crossed"):
        read_urdf(with_more(one, finger.format(kind, limit.format(0.1, 0.0))))


def test_a_leg_joint_without_limits_is_reported(tmp_path: Path) -> None:
    urdf = edited(tmp_path, "wren", '"left_hip_turn" type="revolute"',
                  '"left_hip_turn" type="continuous"')  # fmt: skip
    assert "left_hip_turn: no limits in the URDF, so half a turn either way." in told(drafted(urdf))


def test_a_revolute_joint_with_no_more_than_a_motor_is_limitless(tmp_path: Path) -> None:
    """An exporter leaves the angles out that it was not given."""
    limits = r'(<joint name="left_hip_turn".*?<limit) lower="[^"]*" upper="[^"]*"'
    found = drafted(edited(tmp_path, "wren", limits, r"\1"))
    assert "left_hip_turn: no limits in the URDF" in told(found)
    joint = found.body.model.getJointId("left_hip_turn")
    assert found.body.range(joint) == pytest.approx((-np.pi, np.pi))


def test_a_joint_that_is_fixed_in_one_leg_is_named(tmp_path: Path) -> None:
    """Or what is left of the leg is no leg, and the arms are taken for both."""
    urdf = edited(tmp_path, "wren", '"left_ankle_sway" type="revolute"',
                  '"left_ankle_sway" type="fixed"')  # fmt: skip
    with pytest.raises(FileError, match=r"left_ankle_sway: is fixed, but right_ankle_sway moves"):
        drafted(urdf)


def test_limits_that_may_be_degrees_are_to_be_checked(tmp_path: Path) -> None:
    limits = r'(<joint name="left_knee".*?<limit) lower="[^"]*" upper="[^"]*"'
    found = drafted(edited(tmp_path, "wren", limits, r'\1 lower="-1.7" upper="126"'))
    assert "left_knee: limits in the URDF are more than a turn and a half" in told(found)
    assert "more than a turn" not in told(draft("wren"))


@pytest.mark.parametrize("heavy", [False, True])
def test_a_base_that_floats_in_the_world_is_the_root(heavy: bool, tmp_path: Path) -> None:
    """As MuJoCo wants it; a link with mass is no world."""
    ball = (
        FINGER.format("world", "x", "").partition("<joint")[0] if heavy else '<link name="world"/>'
    )
    joint = """<joint name="float" type="floating"><parent link="world"/>
        <child link="body"/></joint>"""
    urdf = with_more(tmp_path, ball + joint)
    if heavy:
        with pytest.raises(FileError, match="only revolute"):
            read_urdf(urdf)
        return
    model, known = read_urdf(urdf).model, read_urdf(ROBOTS / "wren.urdf").model
    assert list(model.names) == list(known.names)
    spec = mujoco.MjSpec.from_string(with_joints_plain(urdf.read_text()))
    assert spec.body("body") is not None
    drafted(urdf)


def test_meshes_of_thighs_that_are_not_installed(tmp_path: Path) -> None:
    """Only their capsules are lost."""
    urdf = with_meshes(tmp_path, "thigh")
    found = drafted(urdf)
    assert "left_thigh" not in [capsule.name for capsule in found.capsules]
    assert "left_shank" in [capsule.name for capsule in found.capsules]
    assert "Mesh package://wren_meshes/left.stl is not there, and 1 more are of no use." in told(
        found
    )


def test_meshes_of_feet_that_are_not_installed(tmp_path: Path) -> None:
    """Sensors below the foot have shapes of their own: they are not its sole."""
    pad = """<link name="{0}_pad"><collision><geometry><box size="0.01 0.01 0.005"/></geometry>
        </collision></link><joint name="{0}_pad" type="fixed"><parent link="{0}_sole"/>
        <child link="{0}_pad"/><origin xyz="0.03 0 0"/></joint>"""
    urdf = with_meshes(tmp_path, "sole")
    text = urdf.read_text().replace("</robot>", pad.format("left") + pad.format("right"))
    urdf.write_text(f"{text}</robot>")
    with pytest.raises(FileError) as caught:
        draft_robot(urdf, "wren")
    assert "link left_sole: its mesh package://wren_meshes/left.stl is not there, so its sole" in (
        str(caught.value)
    )
    assert str(caught.value).endswith("(--mesh-dir), or measure the sole (--sole)")


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"", "is empty"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 9\n", "git lfs pull"),
        (b"no mesh at all", "is no mesh that can be read"),
    ],
)
def test_meshes_that_cannot_be_had(content: bytes, why: str, tmp_path: Path) -> None:
    """Named with their link and what is the matter; a measured sole makes them needless."""
    folder = tmp_path / "wren_meshes"
    folder.mkdir()
    for side in ("left", "right"):
        (folder / f"{side}.stl").write_bytes(content)
    urdf = with_meshes(tmp_path, "sole")
    with pytest.raises(
        FileError, match=r"link left_sole: its mesh package://wren_meshes/left\.stl"
    ) as caught:
        draft_robot(urdf, "wren")
    assert why in str(caught.value)
    size = SoleSize(back=0.03, front=0.05, inner=0.02, outer=0.03, height=0.036)
    assert why in told(draft_robot(urdf, "wren", sole=size))


def test_a_measured_sole_that_the_foot_reaches_through(tmp_path: Path) -> None:
    size = SoleSize(back=0.03, front=0.05, inner=0.02, outer=0.03, height=0.01)
    with pytest.raises(
        FileError, match=r"--sole: by it the ankle is 0.01 m above .* 0.036 m below"
    ):
        draft_robot(ROBOTS / "wren.urdf", "wren", sole=size)


def test_a_measured_sole(tmp_path: Path) -> None:
    """Without any shape; the feet are each other's mirror image."""
    urdf = edited(tmp_path, "wren", NO_SHAPES, "")
    size = SoleSize(back=0.03, front=0.05, inner=0.02, outer=0.03, height=0.036)
    found = draft_robot(urdf, "wren", sole=size)
    prove(found, robot_text(found, urdf.name), shoe_text(found))
    left, right = found.soles
    np.testing.assert_allclose(left.outline.min(axis=0), [-0.03, -0.02])
    np.testing.assert_allclose(left.outline.max(axis=0), [0.05, 0.03])
    np.testing.assert_allclose(right.outline.min(axis=0), [-0.03, -0.03])
    known = draft("wren").soles[0]
    np.testing.assert_allclose(left.placement.homogeneous, known.placement.homogeneous, atol=1e-6)
    assert "Measured soles of left_sole and right_sole" in told(found)


def test_a_sole_in_millimetres_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    urdf = edited(tmp_path, "wren", NO_SHAPES, "")
    words = ["new", "robot", str(urdf), "--sole", "30", "50", "20", "30", "36"]
    assert main(words) == 1
    assert "--sole: BACK is 30; give it in metres" in capsys.readouterr().err
    metres = ["0.03", "0.05", "0.02", "0.03", "0.036"]
    assert main(["new", "robot", str(urdf), "--sole", *metres]) == 0


def test_the_declared_sensor_of_several_with_like_names(tmp_path: Path) -> None:
    """A gyroscope beside it, higher up, has `ft` in its name, too."""
    more = ""
    for side in ("left", "right"):
        more += MOUNT.format(f"{side}_foot_ft_gyro", f"{side}_sole", "-0.02 0 0")
        more += MOUNT.format(f"{side}_foot_ft", f"{side}_sole", "0.01 0 0")
        more += DECLARED.format(f"{side}_foot_ft", STILL)
    found = drafted(with_more(tmp_path, more))
    assert [one.name for one in found.six_axis if one] == ["left_foot_ft", "right_foot_ft"]
    assert "each carry a part" not in told(found)


def test_a_sensor_declared_on_the_ankle_joint_itself(tmp_path: Path) -> None:
    """Its place is a pose in the foot."""
    more = "".join(
        DECLARED.format(f"{side}_ankle_sway", "0.01 0 0 0 -1.5707963267948966 0")
        for side in ("left", "right")
    )
    found = drafted(with_more(tmp_path, more))
    sensor = found.six_axis[0]
    assert sensor is not None
    assert sensor.signs == (1, 1, 1)
    np.testing.assert_allclose(sensor.origin, [0.0, 0.0, 0.026], atol=1e-6)


def test_two_sensors_a_foot_are_reported(tmp_path: Path) -> None:
    more = ""
    for side in ("left", "right"):
        for end, place in (("front", "0 0 0.03"), ("rear", "0 0 -0.03")):
            more += MOUNT.format(f"{side}_{end}_ft", f"{side}_sole", place)
            more += DECLARED.format(f"{side}_{end}_ft", STILL)
    note = "left_front_ft, left_rear_ft, right_front_ft, right_rear_ft each carry a part"
    assert note in told(drafted(with_more(tmp_path, more)))


def test_frames_that_stand_elsewhere_along_their_axes(tmp_path: Path) -> None:
    """As CAD exports put them; a hinge is the same wherever along it its frame stands."""
    names = [name for name in draft("wren").leg_names if name.startswith("right_")]
    along_m = dict(zip(names, np.linspace(-0.04, 0.05, len(names)), strict=True))
    found, known = drafted(slid(tmp_path, along_m)), draft("wren")
    assert found.leg_names == known.leg_names
    for one, other in zip(found.soles, known.soles, strict=True):
        np.testing.assert_allclose(one.outline, other.outline, atol=2e-4)
        np.testing.assert_allclose(one.in_base.homogeneous, other.in_base.homogeneous, atol=1e-6)
        assert one.height == pytest.approx(other.height, abs=1e-6)
    assert found.posture == pytest.approx(known.posture, abs=2e-3)


def test_a_base_that_looks_backwards(tmp_path: Path) -> None:
    """Names tell left from right; the robot looks along its base's -x."""
    base = """<link name="base"/><joint name="turned" type="fixed"><parent link="base"/>
        <child link="body"/><origin xyz="0 0 0" rpy="0 0 3.141592653589793"/></joint>"""
    found = drafted(with_more(tmp_path, base))
    np.testing.assert_allclose(found.legs.forward, [-1, 0, 0], atol=1e-9)
    known = draft("wren")
    for one, other in zip(found.soles, known.soles, strict=True):
        np.testing.assert_allclose(one.outline, other.outline, atol=2e-4)
    assert found.posture == pytest.approx(known.posture, abs=2e-3)


def test_a_foot_beside_its_ankle_stands_on_its_lowest_face() -> None:
    """Its sides lean in: the vertical through the ankle passes beside it, and meets one of them."""
    body = draft("wren").body
    joint = draft("wren").legs.chains[0][-1]
    wide, narrow = (
        [(x, y, z) for x in (-0.05, 0.06) for y in (0.07 - half, 0.07 + half)]
        for half, z in ((0.04, -0.03), (0.02, -0.04))
    )
    ankle, placement = body.centres[joint], body.placements[joint]
    points = np.array([placement.actInv(ankle + np.array(one)) for one in (*wide, *narrow)])
    sole = find_sole(body, joint, points, np.array([1.0, 0.0, 0.0]))
    assert sole.height == pytest.approx(0.04)
    np.testing.assert_allclose(sole.in_base.rotation[:, 2], (0.0, 0.0, 1.0), atol=1e-9)
    np.testing.assert_allclose(np.ptp(sole.outline, axis=0), (0.11, 0.04), atol=1e-4)


def test_hips_whose_pitch_axis_is_tilted(tmp_path: Path) -> None:
    """By 30 degrees, as some makers do: bending them turns the feet, and the posture makes up."""
    urdf = tmp_path / "wren.urdf"
    root = ElementTree.parse(ROBOTS / "wren.urdf").getroot()
    for side in ("left", "right"):
        (axis,) = root.findall(f"./joint[@name='{side}_hip_swing']/axis")
        along = float(axis.get("xyz", "").split()[2])
        axis.set("xyz", f"{np.sin(0.52)} 0 {along * np.cos(0.52)}")
    ElementTree.ElementTree(root).write(urdf)
    found = draft_robot(urdf, "wren")
    assert abs(found.posture["left_hip_swing"]) > 0.1
    robot, _ = prove(found, robot_text(found, "wren.urdf"), shoe_text(found))
    (height, *tilt), yaw = np.split(
        Kinematics(robot).states(robot.posture[None]).right_sole[0, 2:], [3]
    )
    assert abs(height) < 1e-3
    assert np.abs([*tilt, *yaw]).max() < 5e-3


def test_a_mimic_that_was_left_on_a_fixed_joint(tmp_path: Path) -> None:
    mimic = '<mimic joint="left_knee" multiplier="1" offset="0"/>'
    finger = FINGER.format("finger", "left_forearm", mimic).replace("continuous", "fixed")
    urdf = with_more(tmp_path, finger)
    assert read_urdf(urdf).mimics == {}
    drafted(urdf)


@pytest.mark.parametrize(("low", "high"), [(0.1003, 1.0), (-1.0, -0.1003)])
def test_a_joint_that_cannot_be_at_zero_is_drafted_within_its_limits(
    low: float, high: float, tmp_path: Path
) -> None:
    """Nearest to zero, in milliradians that the limits hold."""
    limit = f'<limit lower="{low}" upper="{high}" effort="1" velocity="1"/>'
    finger = FINGER.format("finger", "left_forearm", limit).replace("continuous", "revolute")
    found = drafted(with_more(tmp_path, finger))
    assert abs(found.posture["finger"]) == pytest.approx(0.101)


def test_contact_points_make_a_sole(tmp_path: Path) -> None:
    """Spheres without a radius in the corners of the box that the foot has."""
    boxed = draft("wren")
    text = re.sub(NO_SHAPES, "", (ROBOTS / "wren.urdf").read_text(), flags=re.DOTALL)
    for foot, side in enumerate(("left", "right")):
        sole = boxed.soles[foot]
        points = "".join(
            f'<collision><origin xyz="{x} {y} {z}"/><geometry><sphere radius="0"/></geometry>'
            "</collision>"
            for x, y, z in (sole.placement.act(np.array([*one, 0.0])) for one in sole.outline)
        )
        link = f'<link name="{side}_sole">'
        assert sole.link == f"{side}_sole"
        text = text.replace(link, link + points)
    urdf = tmp_path / "wren.urdf"
    urdf.write_text(text)
    found = drafted(urdf)
    for known, points_alone in zip(boxed.soles, found.soles, strict=True):
        np.testing.assert_allclose(np.ptp(points_alone.outline, axis=0),
                                   np.ptp(known.outline, axis=0), atol=1e-3)  # fmt: skip
        assert points_alone.height == pytest.approx(known.height, abs=1e-3)


def test_limits_with_the_wrong_sign_are_named(tmp_path: Path) -> None:
    """Of a hip, to be checked; of a knee, that then does not bend."""
    text = (ROBOTS / "wren.urdf").read_text()
    assert not draft("wren").crossed
    for joint in ("left_hip_sway", "left_knee"):
        start = text.index(f'<joint name="{joint}"')
        end = text.index("</joint>", start)
        low, high = (
            float(one) for one in re.findall(r'(?:lower|upper)="([^"]*)"', text[start:end])
        )
        turned = re.sub('lower="[^"]*" upper="[^"]*"', f'lower="{-high}" upper="{-low}"',
                        text[start:end])  # fmt: skip
        (tmp_path / "wren.urdf").write_text(text[:start] + turned + text[end:])
        if joint == "left_knee":
            with pytest.raises(FileError, match="those of right_knee with the wrong sign"):
                draft_robot(tmp_path / "wren.urdf", "wren")
        else:
            assert (
                "left_hip_sway and right_hip_sway: the limits are each other's with the wrong sign."
                in told(drafted(tmp_path / "wren.urdf"))
            )
