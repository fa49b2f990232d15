"""A corrected MJCF is the same robot as the corrected URDF, in MuJoCo."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from numpy.testing import assert_allclose

from shoecal_core.drafting.mjcf import as_urdf
from shoecal_core.robot.correction import ModelCorrection, corrected_urdf
from shoecal_core.robot.mjcf import MjcfError, corrected_mjcf
from shoecal_core.robot.robot import Robot, first_link
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.robot.urdf import read_urdf

CONFIG = Path(__file__).parents[3] / "config" / "robots"
NOTHING = ModelCorrection({}, {}, {})


@pytest.fixture(scope="module")
def wren() -> Robot:
    return load_robot(CONFIG / "wren.yaml")


@pytest.fixture
def mjcf(wren: Robot, tmp_path: Path) -> Path:
    """Wren as a lab has it: a servo, a force sensor, a keyframe, an include, a folder of meshes."""
    spec = mujoco.MjSpec.from_file(str(wren.urdf))
    spec.compiler.fusestatic = False
    base = spec.worldbody.first_body()
    base.add_freejoint()
    servo = spec.add_actuator(
        name="servo", target="left_ankle_swing", trntype=mujoco.mjtTrn.mjTRN_JOINT
    )
    servo.set_to_position(kp=20.0)
    sole = first_link(wren.model, wren.feet[0].joint).name
    spec.body(sole).add_site(name="felt")
    spec.add_sensor(
        name="force", type=mujoco.mjtSensor.mjSENS_FORCE, objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname="felt",
    )  # fmt: skip
    folder = tmp_path / "lab"
    (folder / "shapes").mkdir(parents=True)
    (folder / "shapes" / "wedge.obj").write_text(
        "v 0 0 0\nv 0.01 0 0\nv 0 0.01 0\nv 0 0 0.01\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
    spec.compile()
    text = spec.to_xml().replace("<compiler ", '<compiler meshdir="shapes" ', 1)
    keys = " ".join(["0 0 1 1 0 0 0", *["0.1"] * len(wren.joint_names)])
    text = text.replace(
        "</mujoco>",
        '<include file="assets.xml"/>'
        '<worldbody><geom type="mesh" mesh="wedge"/></worldbody>'
        f'<keyframe><key name="stand" qpos="{keys}"/></keyframe></mujoco>',
    )
    (folder / "assets.xml").write_text(
        '<mujocoinclude><asset><mesh name="wedge" file="wedge.obj"/></asset></mujocoinclude>'
    )
    file = folder / "wren.xml"
    file.write_text(text)
    return file


def compiled(text: str, folder: Path) -> mujoco.MjModel:
    """Of a copy in another folder than the original."""
    folder.mkdir(exist_ok=True)
    (folder / "robot.xml").write_text(text)
    return mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))


def drawn(robot: Robot) -> ModelCorrection:
    rng, model = np.random.default_rng(5), robot.model
    links = [
        first_link(model, joint).name
        for joint in range(1, model.njoints)
        if model.inertias[joint].mass > 0.0
    ]
    return ModelCorrection(
        zeros={name: float(rng.normal(0.0, 0.03)) for name in robot.joint_names},
        masses={name: float(rng.uniform(0.9, 1.1)) for name in links},
        coms={name: rng.normal(0.0, 3e-3, 3) for name in links},
    )


def test_it_moves_and_weighs_as_the_corrected_urdf(wren: Robot, mjcf: Path, tmp_path: Path) -> None:
    correction = drawn(wren)
    text, left = corrected_mjcf(mjcf, wren, correction)
    assert not left
    model = compiled(text, tmp_path / "out")
    urdf = tmp_path / "robot.urdf"
    urdf.write_text(corrected_urdf(wren.urdf.read_text(), wren, correction))
    robot = read_urdf(urdf).model
    data, state, rng = mujoco.MjData(model), robot.createData(), np.random.default_rng(6)
    base = first_link(robot, 1)
    for _ in range(10):
        q = pin.neutral(robot)
        q[7:] = rng.uniform(robot.lowerPositionLimit[7:], robot.upperPositionLimit[7:])
        for joint in range(2, robot.njoints):
            place = int(model.joint(robot.names[joint]).qposadr[0])
            data.qpos[place] = q[robot.joints[joint].idx_q]
        data.qpos[3:7] = 1.0, 0.0, 0.0, 0.0
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        pin.framesForwardKinematics(robot, state, q)
        origin = data.body(base.name).xpos
        assert_allclose(
            pin.centerOfMass(robot, state, q), data.body(base.name).subtree_com - origin, atol=1e-9
        )
        for joint in range(2, robot.njoints):
            link = first_link(robot, joint)
            there = state.oMi[joint] * link.placement
            assert_allclose(there.translation, data.body(link.name).xpos - origin, atol=1e-9)
            assert_allclose(there.rotation, data.body(link.name).xmat.reshape(3, 3), atol=2e-9)
    assert_allclose(model.body_subtreemass[1], pin.computeTotalMass(robot), rtol=1e-9)


def test_readings_of_keyframes_and_targets_stay(wren: Robot, mjcf: Path, tmp_path: Path) -> None:
    before = mujoco.MjModel.from_xml_path(str(mjcf))
    text, _ = corrected_mjcf(mjcf, wren, drawn(wren))
    after = compiled(text, tmp_path / "out")
    assert_allclose(after.key_qpos, before.key_qpos)
    for name in ("jnt_range", "actuator_gainprm", "actuator_biasprm", "jnt_axis", "body_pos"):
        assert_allclose(getattr(after, name), getattr(before, name), rtol=1e-5, atol=1e-9)


def test_what_gives_plays_and_is_late_has_its_place(
    wren: Robot, mjcf: Path, tmp_path: Path
) -> None:
    correction = ModelCorrection(
        {}, {}, {}, {"left_ankle_swing": 0.02, "right_ankle_swing": 0.01},
        {"left_ankle_swing": 0.01},
        {"left": 0.03, "right": 0.02},
    )  # fmt: skip
    text, left = corrected_mjcf(mjcf, wren, correction)
    assert [line.split(":")[0] for line in left] == [
        "compliance of right_ankle_swing", "latency of the right foot"
    ]  # fmt: skip
    model = compiled(text, tmp_path / "out")
    servo = model.actuator("servo")
    assert_allclose(1.0 / servo.gainprm[0], 1.0 / 20.0 + 0.02, rtol=1e-4)
    assert_allclose(servo.biasprm[1], -servo.gainprm[0])
    play = model.joint("left_ankle_swing_play")
    assert_allclose(np.ptp(play.range), 0.01, rtol=1e-5)
    ankle = model.joint("left_ankle_swing")
    assert play.bodyid == ankle.bodyid
    key = model.key("stand").qpos
    assert key[play.qposadr[0]] == 0.0
    assert key[ankle.qposadr[0]] == pytest.approx(0.1)
    assert np.count_nonzero(key[7:]) == len(wren.joint_names)
    assert model.sensor_delay[model.sensor("force").id] == pytest.approx(0.03)
    data = mujoco.MjData(model)
    for _ in range(200):
        mujoco.mj_step(model, data)
    assert np.isfinite(data.qpos).all()
    assert np.isfinite(data.sensordata).all()


def test_masses_of_shapes_and_a_given_total_become_explicit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On a robot whose URDF is made of the MJCF; the angle's unit is degrees."""
    monkeypatch.chdir(tmp_path)  # MuJoCo logs there that settotalmass is deprecated
    file = tmp_path / "odd.xml"
    file.write_text("""<mujoco><compiler angle="degree" settotalmass="4" inertiafromgeom="true"/>
      <worldbody><body name="torso"><freejoint/><geom size="0.1"/>
      <body name="leg" pos="0 0 -0.2" euler="10 0 0"><joint name="hip" axis="0 1 0" ref="5"
      range="-40 40" stiffness="2" springref="3" pos="0 0 0.02"/><geom size="0.05" pos="0 0 -0.1"/>
      </body></body></worldbody></mujoco>""")
    urdf = as_urdf(file, "meshes").write(tmp_path / "odd.urdf")
    model = read_urdf(urdf).model
    robot = replace(load_robot(CONFIG / "wren.yaml"), model=model, urdf=urdf)
    correction = ModelCorrection({"hip": 0.04}, {"leg": 1.5}, {"leg": np.array([0.01, 0.0, 0.0])})
    text, _ = corrected_mjcf(file, robot, correction)
    before, after = mujoco.MjModel.from_xml_path(str(file)), compiled(text, tmp_path / "out")
    leg = after.body("leg").id
    assert_allclose(after.body_mass[leg], 1.5 * before.body_mass[leg], rtol=1e-9)
    assert_allclose(after.body_mass[1], before.body_mass[1], rtol=1e-5)
    assert_allclose(after.body_ipos[leg] - before.body_ipos[leg], [0.01, 0.0, 0.0], atol=1e-9)
    assert_allclose(after.body_inertia[leg], 1.5 * before.body_inertia[leg], rtol=1e-5)
    assert_allclose(after.qpos0[7] - before.qpos0[7], 0.04, atol=1e-9)
    assert_allclose(after.qpos_spring[7] - before.qpos_spring[7], 0.04, atol=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ("left_ankle_swing", "other", "joint left_ankle_swing"),
        ("left_shank", "other", "body left_shank"),
    ],
)
def test_another_robot_is_refused_with_its_cure(
    wren: Robot, mjcf: Path, old: str, new: str, field: str
) -> None:
    assert f'"{old}"' in mjcf.read_text()
    mjcf.write_text(mjcf.read_text().replace(f'"{old}"', f'"{new}"'))
    with pytest.raises(MjcfError, match="rename it there, or make") as raised:
        corrected_mjcf(mjcf, wren, drawn(wren))
    assert (raised.value.path, raised.value.field) == (mjcf, field)


def test_an_axis_that_points_elsewhere_is_noticed(wren: Robot, mjcf: Path) -> None:
    spec = mujoco.MjSpec.from_file(str(mjcf))
    knee = spec.joint("left_knee")
    knee.axis = -np.array(knee.axis)
    spec.compile()
    mjcf.write_text(spec.to_xml())
    with pytest.raises(MjcfError, match="one source"):
        corrected_mjcf(mjcf, wren, NOTHING)
