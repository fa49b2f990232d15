"""A URDF made of an MJCF moves, weighs and looks as MuJoCo has it."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from core.shoe.shoes import ROOT
from shoecal_core.drafting.body import read_body
from shoecal_core.drafting.mjcf import EFFORT_M, MOST_EFFORT_M, SPEED, as_urdf
from shoecal_core.robot.link_shapes import find_shapes
from shoecal_core.robot.mjcf import MjcfError

ODD = """
<mujoco model="odd">
  <compiler angle="degree" autolimits="true"/>
  <default><joint armature="0.01"/><motor ctrlrange="-2 2" gear="3"/></default>
  <asset><mesh name="wedge" vertex="0 0 0  0.1 0 0  0 0.06 0  0 0 0.04  0.1 0.06 0"/></asset>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="torso" pos="0.1 0.2 0.5" quat="0.9 0.1 0.2 0.3">
      <freejoint/>
      <geom type="capsule" size="0.05 0.1" mass="1.5"/>
      <body name="leg" pos="0.02 0.05 -0.15" euler="10 20 30">
        <joint name="yaw" axis="0 0 1" pos="0.01 0 0.02" range="-40 40"/>
        <joint name="roll" axis="1 0.2 0" pos="0 0.01 0.03" range="-30 60" ref="12"/>
        <joint name="loose" axis="0 1 0" range="-0.5 0.5"/>
        <geom type="box" size="0.02 0.03 0.08" pos="0 0 -0.1" euler="0 15 0" mass="0.4"/>
        <body name="shank" pos="0.01 0 -0.2">
          <joint name="slide" type="slide" axis="0 0 1" range="-0.02 0.03" ref="0.01"/>
          <geom type="cylinder" size="0.02 0.05" mass="0.2"/>
          <body name="foot" pos="0 0 -0.1">
            <joint name="ankle" axis="0 1 0" range="-50 50" actuatorfrcrange="-4 4"/>
            <geom type="mesh" mesh="wedge" mass="0.1" pos="-0.03 -0.02 -0.01" euler="0 0 5"/>
            <site name="sole" pos="0.01 0 -0.02" euler="0 0 90"/>
          </body>
        </body>
      </body>
      <body name="head" pos="0 0 0.2"><geom type="sphere" size="0.05" mass="0.3"/></body>
    </body>
  </worldbody>
  <actuator><motor joint="yaw"/><position joint="roll" kp="20" forcerange="-5 5"/></actuator>
  <sensor><force site="sole"/><torque site="sole"/></sensor>
</mujoco>
"""


@pytest.fixture
def odd(tmp_path: Path) -> Path:
    """With all that an exporter may write: references, several joints in a body, anchors."""
    file = tmp_path / "odd.xml"
    file.write_text(ODD)
    return file


def test_it_moves_and_weighs_as_in_mujoco(odd: Path, tmp_path: Path) -> None:
    urdf = as_urdf(odd, "odd_meshes").write(tmp_path / "odd.urdf")
    model = mujoco.MjModel.from_xml_path(str(odd))
    data, body = mujoco.MjData(model), read_body(urdf)
    robot, rng = body.model, np.random.default_rng(1)
    state, base = robot.createData(), model.body("torso").id
    assert pin.computeTotalMass(robot) == pytest.approx(2.5)
    assert set(robot.names[2:]) == {"yaw", "roll", "slide", "ankle"}
    for _ in range(10):
        q = pin.neutral(robot)
        for joint in range(2, robot.njoints):
            place = robot.joints[joint].idx_q
            low, high = robot.lowerPositionLimit[place], robot.upperPositionLimit[place]
            q[place] = rng.uniform(low, high)
            data.qpos[model.joint(robot.names[joint]).qposadr[0]] = q[place]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        pin.framesForwardKinematics(robot, state, q)
        turned, origin = data.xmat[base].reshape(3, 3), data.xpos[base]
        com = turned.T @ (data.subtree_com[base] - origin)
        assert_allclose(pin.centerOfMass(robot, state, q), com, atol=1e-9)
        site = state.oMf[robot.getFrameId("sole_force_torque")]
        there = data.site("sole")
        assert_allclose(site.translation, turned.T @ (there.xpos - origin), atol=1e-9)
        assert_allclose(site.rotation, turned.T @ there.xmat.reshape(3, 3), atol=1e-9)


def test_shapes_are_where_mujoco_has_them(odd: Path, tmp_path: Path) -> None:
    """The hull of a mesh, which MuJoCo puts elsewhere than its file does."""
    body = read_body(as_urdf(odd, "odd_meshes").write(tmp_path / "odd.urdf"))
    model = mujoco.MjModel.from_xml_path(str(odd))
    data, foot = mujoco.MjData(model), model.body("foot")
    mujoco.mj_kinematics(model, data)
    geom = int(foot.geomadr[0])
    vertices = model.mesh_vert @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]
    wanted = (vertices - data.body("foot").xpos) @ data.body("foot").xmat.reshape(3, 3)
    ankle = body.model.getJointId("ankle")
    found = find_shapes(body, {ankle}).points[ankle]
    for bound in (np.min, np.max):
        assert_allclose(bound(found, axis=0), bound(wanted, axis=0), atol=1e-6)


def test_limits_of_motors_are_found_or_said_to_be_put_in(odd: Path) -> None:
    made = as_urdf(odd, "odd_meshes")
    limits = {
        joint.get("name"): joint.find("limit")
        for joint in ElementTree.fromstring(made.urdf).iter("joint")
    }
    efforts = {
        name: float(one.get("effort", "")) for name, one in limits.items() if one is not None
    }
    weight = 2.5 * 9.81
    assert efforts == pytest.approx(
        {"yaw": 6.0, "roll": 15.0, "slide": EFFORT_M * weight, "ankle": 4.0}, rel=1e-5
    )
    assert {float(one.get("velocity", "")) for one in limits.values() if one is not None} == {SPEED}
    told = "\n".join(one.found for one in made.assumed)
    for word in ("slide", "loose", "3 rad/s"):
        assert word in told
    assert "ankle" not in told


def test_a_limit_that_is_no_motor_s_is_not_believed(tmp_path: Path) -> None:
    """Range of control -200 to 200, as in models that learning has no use for limits in."""
    weight = 2.5 * 9.81
    for control, effort in ((15.0, 45.0), (200.0, EFFORT_M * weight)):
        file = tmp_path / "strong.xml"
        file.write_text(ODD.replace('ctrlrange="-2 2"', f'ctrlrange="-{control} {control}"'))
        made = as_urdf(file, "meshes")
        limits = {
            joint.get("name"): joint.find("limit")
            for joint in ElementTree.fromstring(made.urdf).iter("joint")
        }
        found = limits["yaw"]
        assert found is not None
        assert float(found.get("effort", "")) == pytest.approx(effort, rel=1e-5)
        told = "\n".join(one.found for one in made.assumed)
        assert ("yaw 600 N m" in told) == (control > 15.0)
        assert effort < MOST_EFFORT_M * weight


def test_a_base_that_hangs_on_the_world_is_to_get_a_free_joint(tmp_path: Path) -> None:
    fixed = tmp_path / "fixed.xml"
    spec = mujoco.MjSpec.from_file(str(ROOT / "config/robots/wren.urdf"))
    spec.compile()
    fixed.write_text(spec.to_xml())
    (lost,) = (one for one in as_urdf(fixed, "meshes").assumed if "hangs on the world" in one.found)
    assert "free joint" in lost.look


@pytest.mark.parametrize(
    ("old", "new", "field", "word"),
    [
        ('<joint name="ankle" axis="0 1 0" range="-50 50" actuatorfrcrange="-4 4"/>',
         '<joint name="ankle" type="ball"/>', "joint ankle", "three hinges"),
        ('mesh="wedge" mass', 'mesh="gone" mass', "", "MuJoCo does not read it"),
    ],
)  # fmt: skip
def test_what_is_not_of_hinges_is_refused_with_its_cure(
    odd: Path, old: str, new: str, field: str, word: str
) -> None:
    text = odd.read_text()
    assert old in text
    odd.write_text(text.replace(old, new))
    with pytest.raises(MjcfError, match=word) as raised:
        as_urdf(odd, "odd_meshes")
    assert raised.value.field == field
    assert raised.value.path == odd


def test_keyframes_are_kept_by_joint(odd: Path) -> None:
    key = """<keyframe><key name="home" qpos="0 0 1 1 0 0 0  0.1 0.2 0.3 0.01 0.5"/>
        <key qpos="0 0 1 1 0 0 0  0 0 0 0 0"/></keyframe><sensor>"""
    odd.write_text(odd.read_text().replace("<sensor>", key).replace('range="-0.5 0.5"', ""))
    found = as_urdf(odd, "meshes").keyframes
    assert found["home"] == {"yaw": 0.1, "roll": 0.2, "loose": 0.3, "slide": 0.01, "ankle": 0.5}
    assert list(found) == ["home", "key_1"]


ROD = """<body name="rod" pos="0 0 -0.1">
      <joint name="bearing" type="ball"/><geom type="sphere" size="0.01" mass="0.05"/>
    </body></body>
    <body name="head" pos="0 0 0.2">"""


def test_what_closes_a_chain_is_written_down(odd: Path) -> None:
    """A rod on a ball; what is not active, or holds to the world, closes none."""
    text = odd.read_text()
    closing = """<equality>
      <connect name="rod" body1="rod" body2="shank" anchor="0 0 0"/>
      <weld name="hook" body1="torso"/>
      <weld name="pin" body1="foot" body2="torso" active="false"/>
    </equality><sensor>"""
    end_of_leg = '</body>\n      <body name="head" pos="0 0 0.2">'
    assert end_of_leg in text
    text = text.replace(end_of_leg, ROD)
    odd.write_text(text.replace("<sensor>", closing))
    (loop,) = ElementTree.fromstring(as_urdf(odd, "meshes").urdf).iter("loop_joint")
    ends = [end.get("link") for end in loop]
    assert (loop.get("name"), ends) == ("rod", ["rod", "shank"])


def with_lost_mesh(text: str, inertial: str) -> str:
    """A cover on the shank, of a mesh that is in no folder."""
    text = text.replace("<asset>", '<asset><mesh name="cover" file="cover.stl"/>')
    cover = f'{inertial}<geom type="mesh" mesh="cover"/>'
    place = '<joint name="slide" type="slide" axis="0 0 1" range="-0.02 0.03" ref="0.01"/>'
    assert place in text
    return text.replace(place, place + cover)


@pytest.mark.parametrize(
    ("content", "why"),
    [(None, "is not there"), (b"", "is empty"),
     (b"version https://git-lfs.github.com/spec/v1", "Git LFS pointer")],
)  # fmt: skip
def test_lost_meshes_are_left_out(content: bytes | None, why: str, odd: Path) -> None:
    """As far as no mass follows from them."""
    text = odd.read_text()
    if content is not None:
        (odd.parent / "cover.stl").write_bytes(content)
    inertial = '<inertial pos="0 0 0" mass="0.2" diaginertia="1e-4 1e-4 1e-4"/>'
    odd.write_text(with_lost_mesh(text, inertial))
    converted = as_urdf(odd, "odd_meshes")
    (note,) = (one.found for one in converted.assumed if "cover.stl" in one.found)
    assert why in note
    assert len(converted.meshes) == 1
    odd.write_text(with_lost_mesh(text, ""))
    with pytest.raises(MjcfError, match=why) as raised:
        as_urdf(odd, "odd_meshes")
    assert raised.value.field == "body shank"


def test_a_suffix_that_mujoco_does_not_know(odd: Path) -> None:
    other = odd.with_suffix(".mjcf")
    other.write_text(odd.read_text())
    assert as_urdf(other, "meshes").urdf == as_urdf(odd, "meshes").urdf


def test_settings_that_mujoco_had_once_are_left_out(odd: Path) -> None:
    wanted = as_urdf(odd, "meshes").urdf
    old = (
        """<option apirate="50"><flag sensornoise="enable"/></option><compiler convexhull="true" """
    )
    odd.write_text(odd.read_text().replace("<compiler ", old, 1))
    assert as_urdf(odd, "meshes").urdf == wanted
    odd.write_text(odd.read_text().replace('gear="3"', 'gears="3"'))
    with pytest.raises(MjcfError, match="gears"):
        as_urdf(odd, "meshes")


def test_a_base_on_slides_and_a_ball_floats(odd: Path) -> None:
    """As before MuJoCo had free joints."""
    wanted = as_urdf(odd, "meshes").urdf
    slides = "".join(f'<joint type="slide" axis="{axis}"/>' for axis in ("1 0 0", "0 1 0", "0 0 1"))
    text = odd.read_text().replace("<freejoint/>", f'{slides}<joint type="ball"/>')
    odd.write_text(text)
    assert as_urdf(odd, "meshes").urdf == wanted
