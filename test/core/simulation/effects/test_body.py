"""Effects of the body against statics by hand: masses, torques times compliance, geometry."""

from __future__ import annotations

import dataclasses

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from core.simulation.effects.chains import item
from core.simulation.worlds import DEFAULT, PERFECT, World, changed
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe import wrench
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw_body


def with_effects(world: World, *effects: Effect) -> SimulatedRobot:
    """At rest in a world that is else as its model says."""
    return world.standing(changed(PERFECT, *effects))


def com(sim: SimulatedRobot) -> FloatArray:
    """(2,) CoM of all that is heavy, over the left sole [m]."""
    snap = sim.snapshot()
    found: FloatArray = snap.sole_rotation[0].T @ (
        sim.data.subtree_com[sim.physics.model.body(sim.drawn.body.links[0]).id]
        - snap.sole_position[0]
    )
    return found[:2]


@pytest.mark.parametrize("mass", [0.3, -0.3])
def test_another_total_mass_raises_the_floors_force_and_leaves_the_com(
    world: World, mass: float
) -> None:
    plain, heavy = with_effects(world), with_effects(world, item("total_mass", "all", mass_kg=mass))
    for sim in (plain, heavy):
        sim.step_to(sim.time + 1.0)
    assert heavy.weight - plain.weight == pytest.approx(mass * GRAVITY, abs=1e-9)
    assert heavy.truth().grf - plain.truth().grf == pytest.approx(mass * GRAVITY, abs=1e-3)
    # The shoes keep their mass, so that the CoM moves by their share of the change.
    assert heavy.truth().cop == pytest.approx(plain.truth().cop, abs=4e-4)
    links = [plain.physics.model.body(name).id for name in plain.drawn.body.links]
    before, after = (sim.physics.model.body_mass[links] for sim in (plain, heavy))
    at = before > 1e-3
    factor = 1.0 + mass / plain.drawn.body.mass
    np.testing.assert_allclose(after[at] / before[at], factor, rtol=1e-9)


def test_a_robot_cannot_lose_more_than_its_mass(nao: World) -> None:
    effect = item("total_mass", "all", mass_kg=-9.0)
    with pytest.raises(FileError, match=r"effects\[0\]\.mass_kg: must be above -[45]\.\d+, the"):
        draw_body(changed(PERFECT, effect), nao.robot, nao.shoe, 1)


def test_a_payload_raises_the_floors_force_by_its_weight(world: World) -> None:
    mass = 0.3
    plain, loaded = with_effects(world), with_effects(world, item("payload", "base", mass_kg=mass))
    for sim in (plain, loaded):
        sim.step_to(sim.time + 1.0)
    assert loaded.weight - plain.weight == pytest.approx(mass * GRAVITY, abs=1e-9)
    assert loaded.truth().grf - plain.truth().grf == pytest.approx(mass * GRAVITY, abs=1e-3)


def test_a_payload_hangs_where_the_model_has_the_links_com(nao: World) -> None:
    mass, link = 0.25, "LForeArm_link"
    sim = with_effects(nao, item("payload", link, mass_kg=mass))
    model, data, robot = sim.physics.model, sim.data, nao.robot
    ball = data.xipos[model.body(f"payload/{link}").id]
    angles = data.qpos[sim.physics.positions]
    base = sim.snapshot()
    configuration = np.concatenate((base.base_position, base.base_orientation, angles))
    reference = robot.model.createData()
    pin.framesForwardKinematics(robot.model, reference, configuration)
    frame = robot.model.frames[robot.model.getFrameId(link)]
    in_urdf = np.array([0.02556, 0.00281, 0.00076])
    expected = reference.oMi[frame.parentJoint] * frame.placement * in_urdf
    assert ball == pytest.approx(expected, abs=1e-5)
    sim.step_to(sim.time + 1.0)
    total = sim.weight / GRAVITY
    own = nao.kinematics.states(sim.joints().angles[None]).com[0, 0, :2]
    snap = sim.snapshot()
    at = (snap.sole_rotation[0].T @ (ball - snap.sole_position[0]))[:2]
    assert sim.truth().cop == pytest.approx(own + mass / total * (at - own), abs=3e-4)


def test_a_links_com_moves_the_robots_by_its_share_of_the_mass(nao: World) -> None:
    shift = np.array([0.01, -0.006, 0.004])
    plain = with_effects(nao)
    moved = with_effects(nao, item("link_com", "base", x_m=0.01, y_m=-0.006, z_m=0.004))
    share = plain.physics.model.body("base_link").mass[0] * GRAVITY / plain.weight
    # The torso stands nearly upright, its axes along the left sole's.
    turn = plain.data.xmat[plain.physics.model.body("base_link").id].reshape(3, 3)
    expected = share * (turn @ shift)[:2]
    # Servos give a little more where they carry more.
    assert com(moved) - com(plain) == pytest.approx(expected, abs=1.5e-4)
    assert moved.truth().cop - plain.truth().cop == pytest.approx(expected, abs=2e-4)
    assert moved.weight == pytest.approx(plain.weight)


def test_joint_offsets_are_the_encoders(nao: World) -> None:
    rules = changed(
        PERFECT,
        item("joint_offset", "LKneePitch", angle_rad=0.02),
        item("joint_offset", "RHipYawPitch", angle_rad=-0.01),
    )
    body = draw_body(rules, nao.robot, nao.shoe, 1)
    error = dict(zip(body.joints, body.encoder_error, strict=True))
    ratio = next(motor.ratio for motor in nao.robot.shared)
    assert error.pop("LKneePitch") == 0.02
    # Both hips' yaw-pitch are one motor with one encoder.
    assert error.pop("RHipYawPitch") == -0.01
    assert error.pop("LHipYawPitch") == pytest.approx(-0.01 / ratio)
    assert not any(error.values())


@pytest.mark.parametrize("joint", ["LKneePitch", "RAnkleRoll", "LHipYawPitch"])
def test_a_compliant_joint_turns_by_torque_times_compliance(nao: World, joint: str) -> None:
    compliance = 0.01
    effect = item("joint_compliance", joint, compliance_rad_per_nm=compliance)
    sim = with_effects(nao, effect)
    sim.step_to(sim.time + 1.0)
    model, data = sim.physics.model, sim.data
    given = float(data.qpos[model.joint(f"gear/{joint}").qposadr[0]])
    # What the link needs of its gear, by MuJoCo's inverse dynamics: contacts, weight, motion.
    inverse = mujoco.MjData(model)
    inverse.qpos[:], inverse.qvel[:], inverse.act[:] = data.qpos, 0.0, data.act
    mujoco.mj_forward(model, inverse)
    spring = model.tendon(f"gear/{joint}").id
    pulled = -model.tendon_stiffness[spring] * inverse.ten_length[spring]
    assert given == pytest.approx(-compliance * pulled, abs=1e-9)
    motor = sim.joints().efforts[nao.robot.joint(joint)]
    if joint != "LHipYawPitch":  # its motor drives two gears
        assert pulled == pytest.approx(motor, abs=0.02 * abs(motor) + 2e-3)
        assert abs(given) > 2e-5


def test_play_lets_the_link_fall_by_half_its_width(nao: World) -> None:
    play = 0.012
    sim = with_effects(nao, item("backlash", "LKneePitch", play_rad=play))
    given = sim.data.qpos[sim.physics.model.joint("gear/LKneePitch").qposadr[0]]
    torque = sim.joints().efforts[nao.robot.joint("LKneePitch")]
    assert abs(torque) > 0.3
    assert given == pytest.approx(-np.sign(torque) * play / 2.0, abs=1e-4)


def test_all_joints_means_those_of_the_legs(world: World) -> None:
    rules = changed(
        PERFECT,
        item("joint_compliance", "all", compliance_rad_per_nm=0.002),
        item("backlash", "all", play_rad=0.003),
    )
    body = draw_body(rules, world.robot, world.shoe, 1)
    legs = np.zeros(len(body.joints))
    legs[world.robot.moved] = 1.0
    assert body.compliance == pytest.approx(0.002 * legs)
    assert body.play == pytest.approx(0.003 * legs)


def test_effects_add_to_what_the_reality_has(nao: World) -> None:
    effects = [item("backlash", "LKneePitch", play_rad=0.01)] * 2
    plain = draw_body(DEFAULT, nao.robot, nao.shoe, 1)
    body = draw_body(changed(DEFAULT, *effects), nao.robot, nao.shoe, 1)
    knee = nao.robot.joint("LKneePitch")
    assert body.play[knee] == pytest.approx(plain.play[knee] + 0.02)
    assert (body.encoder_error == plain.encoder_error).all()


@pytest.mark.parametrize("foot", ["left", "right"])
def test_a_shoe_askew_takes_cells_and_sole_along(nao: World, foot: str) -> None:
    dx, dy, dtheta = 0.006, -0.004, 0.05
    sim = with_effects(nao, item("foot_placement", foot, dx_m=dx, dy_m=dy, dtheta_rad=dtheta))
    index = ("left", "right").index(foot)
    # The model's sole, from the true joint angles and the true root.
    snap, robot = sim.snapshot(), nao.robot
    angles = sim.data.qpos[sim.physics.positions]
    configuration = np.concatenate((snap.base_position, snap.base_orientation, angles))
    reference = robot.model.createData()
    pin.framesForwardKinematics(robot.model, reference, configuration)
    modelled = reference.oMf[robot.feet[index].frame]
    true = pin.SE3(snap.sole_rotation[index], snap.sole_position[index])
    apart = modelled.actInv(true)
    assert apart.translation == pytest.approx([dx, dy, 0.0], abs=1e-4)
    assert pin.log3(apart.rotation) == pytest.approx([0.0, 0.0, dtheta], abs=1e-4)
    # In the true sole frame cells and truth agree as ever.
    found = wrench.cop(wrench.foot_wrenches(nao.shoe, snap.felt), 1.0)
    assert found == pytest.approx(sim.truth().foot_cop, abs=1e-4)


@pytest.mark.parametrize(
    ("effect", "message"),
    [
        (item("payload", "tail", mass_kg=0.1), "no link 'tail' .there are: base_link, "),
        (item("link_com", "all", x_m=0.1), "no link 'all'"),
        (
            item("joint_offset", "LKnee", angle_rad=0.1),
            "no joint 'LKnee' .did you mean 'LKneePitch'. there are: HeadYaw",
        ),
    ],
)
def test_parts_that_there_are_not(nao: World, effect: Effect, message: str) -> None:
    with pytest.raises(FileError, match=rf"mine\.yaml: effects\[0\]\.location: there is {message}"):
        draw_body(dataclasses.replace(PERFECT, effects=(effect,)), nao.robot, nao.shoe, 1)


@pytest.mark.parametrize(
    ("name", "location", "sizes", "message"),
    [
        ("payload", ["base"], {"mass_kg": -1.0}, "mass_kg: must be at least 0"),
        ("payload", ["base"], {}, "mass_kg: is missing"),
        ("payload", ["base"], {"mass_n": 1.0}, "mass_n: unknown key"),
        ("payload", [], {"mass_kg": 1.0}, "location: is missing"),
        ("total_mass", ["base"], {"mass_kg": 0.1}, r"location: must be \[all\]"),
        ("total_mass", ["all"], {}, "mass_kg: is missing"),
        ("joint_offset", ["a", "a"], {"angle_rad": 0.1}, "names one twice"),
        ("foot_placement", ["LFoot"], {"dx_m": 0.1}, "'LFoot' is not one of: left, right, all"),
        ("foot_placement", ["left"], {"dx_m": 1.0}, "dx_m: must be at least -0.1 and at most 0.1"),
    ],
)
def test_items_that_say_it_wrong(
    name: str, location: list[str], sizes: dict[str, float], message: str
) -> None:
    with pytest.raises(FileError, match=message):
        item(name, *location, **sizes)
