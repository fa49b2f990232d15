from __future__ import annotations

import dataclasses
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from core.simulation.worlds import DEFAULT, PERFECT, ROOT, World, changed, load_world
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError, ShoecalError
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe import wrench
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation import robot_physics
from shoecal_core.simulation.sampled_robot import draw
from shoecal_core.simulation.shoe_physics import ChannelOutputs, SoleReader

SIX_AXIS = """
format: 1
name: six_axis
unit: V
height_m: 0.022
converter: {lowest: -10.0, highest: 10.0}
feet:
  left: &foot
    plates: {mass_above_kg: 0.02, com_above_m: [0.0, 0.0, 0.02],
             mass_below_kg: 0.08, com_below_m: [0.01, 0.002, 0.005]}
    six_axis:
      origin_m: [0.01, 0.003, 0.03]
      axes: [{axis: fx}, {axis: fy}, {axis: fz, polarity: -1}, {axis: mx}, {axis: my}]
"""


def six_axis_world(tmp_path: Path, text: str = "") -> World:
    file = tmp_path / "shoe.yaml"
    block = SIX_AXIS.split("&foot\n")[1]
    file.write_text(text or SIX_AXIS.replace(" &foot", "") + "  right:\n" + block)
    shoe = load_shoe(file)
    robot = load_robot(ROOT / "config" / "robots" / "nao.yaml", shoe)
    return World(robot, shoe, load_world("nao").kinematics)


def random_postures(world: World, count: int) -> FloatArray:
    robot = world.robot
    angles = np.random.default_rng(1).uniform(robot.lower, robot.upper, (count, len(robot.lower)))
    for shared in robot.shared:
        angles[:, shared.joint] = shared.ratio * angles[:, shared.leader]
    return angles


def test_masses_and_kinematics_are_the_models_own(world: World) -> None:
    """MuJoCo reads the URDF by itself; Pinocchio knows what must come out."""
    robot = world.robot
    physics = robot_physics.build(robot, world.shoe, draw(PERFECT, robot, world.shoe, 1))
    data, soles = mujoco.MjData(physics.model), SoleReader(physics.model)
    assert physics.model.body_mass.sum() == pytest.approx(robot.mass, abs=1e-5)
    reference = robot.model.createData()
    for angles in random_postures(world, 10):
        data.qpos[physics.positions] = angles
        mujoco.mj_kinematics(physics.model, data)
        mujoco.mj_comPos(physics.model, data)
        configuration = np.concatenate((data.qpos[:3], [0.0, 0.0, 0.0, 1.0], angles))
        com = pin.centerOfMass(robot.model, reference, configuration)
        assert data.subtree_com[0] == pytest.approx(com, abs=1e-6)
        pin.updateFramePlacements(robot.model, reference)
        positions, rotations = soles.pose(data)
        for foot, position, rotation in zip(robot.feet, positions, rotations, strict=True):
            placement = reference.oMf[foot.frame]
            assert position == pytest.approx(placement.translation, abs=1e-9)
            assert rotation == pytest.approx(placement.rotation, abs=1e-9)


def test_link_errors_move_the_com_as_they_should(nao: World) -> None:
    """In the zero pose link frames are parallel to the root's."""
    rules = changed(PERFECT, body__mass_error_fraction={"LThigh_link": 0.5})
    models = [
        robot_physics.build(nao.robot, nao.shoe, draw(one, nao.robot, nao.shoe, 1)).model
        for one in (PERFECT, rules)
    ]
    before, after = models
    scale = after.body("base_link").mass[0] / before.body("base_link").mass[0]
    assert scale < 1.0
    thigh = [model.body("LThigh_link").mass[0] for model in models]
    assert thigh[1] / thigh[0] == pytest.approx(1.5 * scale)
    assert after.body_mass.sum() == pytest.approx(before.body_mass.sum())


def hanging(world: World) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """The robot at rest with its root held in the air."""
    drawn = draw(PERFECT, world.robot, world.shoe, 1)
    spec = robot_physics.build_spec(world.robot, world.shoe, drawn)
    root = spec.worldbody.first_body()
    spec.delete(root.first_joint())
    root.pos = [0.0, 0.0, 2.0]
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, nstep=800)
    mujoco.mj_forward(model, data)
    return model, data


def test_cells_of_a_hanging_foot_feel_the_plate_below_them(world: World) -> None:
    model, data = hanging(world)
    outputs = ChannelOutputs(model, world.shoe)(data)
    found = wrench.foot_wrenches(world.shoe, outputs)
    assert (wrench.weight_below(world.shoe)[:, 0] > 0.4).all()
    # With that weight added a hanging foot reads zero (its sole may be a little tilted).
    assert found[:, 0] == pytest.approx(np.zeros(2), abs=2e-3)
    assert not SoleReader(model).contact(data).any()


def test_six_axis_feet_feel_force_and_moments(tmp_path: Path) -> None:
    world = six_axis_world(tmp_path)
    rules = changed(PERFECT, joints__encoder_error_rad={"LHipRoll": 0.004})
    sim = world.standing(rules)
    truth, felt = sim.truth(), sim.snapshot().felt
    found = wrench.foot_wrenches(world.shoe, felt)
    assert np.abs(truth.foot_force[:, :2]).max() > 0.5
    assert found[:, 0] == pytest.approx(truth.foot_grf, abs=6e-3)
    assert wrench.cop(found, 1.0) == pytest.approx(truth.foot_cop, abs=1e-4)
    assert felt[:2] == pytest.approx(truth.foot_force[0, :2], abs=0.02)
    # The vertical axis is wired the other way round.
    volts, parameters = sim.readings().voltages, sim.drawn.shoes.parameters
    assert parameters.gain[2] < 0.0
    assert parameters.outputs(volts) == pytest.approx(felt, abs=1e-6)


def test_a_foot_with_cells_and_a_sensor_is_refused(tmp_path: Path, nao: World) -> None:
    text = nao.shoe.path.read_text()
    text += "    six_axis: {origin_m: [0, 0, 0.03], axes: [{axis: mx}, {axis: my}]}\n"
    world = six_axis_world(tmp_path, text)
    with pytest.raises(ShoecalError, match=r"feet\.right: has cells and a six-axis sensor"):
        world.simulate(PERFECT)


def test_shapes_and_missing_meshes_of_a_urdf_do_not_matter(tmp_path: Path) -> None:
    odd = load_world("odd_biped")
    shape = (
        '<collision><geometry><mesh filename="package://none/x.stl"/></geometry></collision>'
        '<visual><geometry><box size="1 1 1"/></geometry></visual></link>'
    )
    (tmp_path / "odd_biped.urdf").write_text(odd.robot.urdf.read_text().replace("</link>", shape))
    robot_file = tmp_path / "odd_biped.yaml"
    robot_file.write_text(odd.robot.path.read_text())
    shaped = World(load_robot(robot_file, odd.shoe), odd.shoe, odd.kinematics)
    felt = [world.standing(PERFECT).snapshot().felt for world in (odd, shaped)]
    assert felt[0] == pytest.approx(felt[1])


def test_joints_without_a_torque_limit_are_held(tmp_path: Path) -> None:
    odd = load_world("odd_biped")
    urdf = odd.robot.urdf.read_text()
    root = urdf.partition('<link name="')[2].partition('"')[0]
    fingers = "".join(
        f'<link name="finger{mass}"><inertial><mass value="{mass}"/><inertia ixx="1e-9" iyy="1e-9"'
        ' izz="1e-9" ixy="0" ixz="0" iyz="0"/><origin xyz="0.03 0 0"/></inertial></link>'
        f'<joint name="to{mass}" type="continuous"><parent link="{root}"/>'
        f'<child link="finger{mass}"/><axis xyz="0 1 0"/></joint>'
        for mass in ("2e-06", "0.05")
    )
    (tmp_path / "odd_biped.urdf").write_text(urdf.replace("</robot>", f"{fingers}</robot>"))
    robot_file = tmp_path / "odd_biped.yaml"
    robot_file.write_text(odd.robot.path.read_text())
    robot = load_robot(robot_file, odd.shoe)
    fingered = World(robot, odd.shoe, odd.kinematics)
    assert not robot.effort_limit[[robot.joint("to2e-06"), robot.joint("to0.05")]].any()
    standing = fingered.standing(PERFECT)
    for name in ("to2e-06", "to0.05"):
        assert standing.data.joint(name).qpos[0] == pytest.approx(0.0, abs=0.02)


def test_a_urdf_that_mujoco_refuses_is_one_clear_error(tmp_path: Path) -> None:
    odd = load_world("odd_biped")
    robot_file, urdf = tmp_path / "odd_biped.yaml", tmp_path / "odd_biped.urdf"
    robot_file.write_text(odd.robot.path.read_text())
    urdf.write_text(odd.robot.urdf.read_text())
    robot = load_robot(robot_file, odd.shoe)
    urdf.write_text("<robot>")
    with pytest.raises(FileError, match=r"odd_biped\.urdf: not fit for simulation") as caught:
        World(robot, odd.shoe, odd.kinematics).simulate(DEFAULT)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
def test_engines_agree_on_statics(nao: World, cone: str) -> None:
    usual = nao.standing(DEFAULT)
    engine = dataclasses.replace(DEFAULT.engine, cone=cone, sideways_ratio=3.0)
    other = nao.standing(dataclasses.replace(DEFAULT, engine=engine, step_s=0.001))
    assert other.truth().grf == pytest.approx(usual.weight, abs=0.01)
    assert other.truth().cop == pytest.approx(usual.truth().cop, abs=2e-4)


def test_another_integrator_stands_where_springs_are_soft_and_steps_short(nao: World) -> None:
    soft = changed(
        DEFAULT,
        cells__stiffness_n_per_m=20000.0,
        servo__full_torque_error_rad=0.05,
        floor__contact_time_s=0.01,
    )
    cops = []
    for integrator, step in (("discrete", 0.0005), ("implicitfast", 0.0002)):
        engine = dataclasses.replace(DEFAULT.engine, integrator=integrator)
        sim = nao.standing(dataclasses.replace(soft, engine=engine, step_s=step))
        assert sim.truth().grf == pytest.approx(sim.weight, abs=0.01)
        cops.append(sim.truth().cop)
    assert cops[0] == pytest.approx(cops[1], abs=1e-4)
