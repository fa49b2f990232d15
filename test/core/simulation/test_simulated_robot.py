from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from core.simulation.worlds import DEFAULT, PERFECT, World, changed
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe import wrench
from shoecal_core.simulation.effects.contact import FloorTilt
from shoecal_core.simulation.effects.timing import Latency
from shoecal_core.simulation.faults import RobotFellError, SupportNotReachedError
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.samples import SimulatedSamples, run


def com_in_left_sole(sim: SimulatedRobot) -> FloatArray:
    snap = sim.snapshot()
    com: FloatArray = snap.sole_rotation[0].T @ (sim.data.subtree_com[0] - snap.sole_position[0])
    return com


def lean(world: World, angle: float, duration: float = 2.0) -> JointTrajectory:
    """Both ankles pitched, feet stay flat: the whole body leans."""
    robot = world.robot
    names = [robot.joint_names[index] for index in robot.legs]
    ankles = tuple(name for name in names if "ankle" in name.lower() and "itch" in name)
    start = np.array([robot.posture[robot.joint(name)] for name in ankles])
    return JointTrajectory(ankles, np.array([0.0, duration]), np.array([start, start + angle]))


@pytest.mark.parametrize("rules", [PERFECT, DEFAULT], ids=["perfect", "default"])
def test_at_rest_the_floor_carries_the_weight_below_the_com(
    world: World, rules: PlantVariation
) -> None:
    sim = world.standing(rules)
    sim.step_to(sim.time + 1.0)
    truth = sim.truth()
    mass = sim.drawn.body.mass + world.shoe.mass
    assert sim.weight == pytest.approx(mass * GRAVITY, abs=1e-4)
    assert truth.grf == pytest.approx(sim.weight, abs=1e-3)
    assert truth.cop == pytest.approx(com_in_left_sole(sim)[:2], abs=1e-4)
    # What one foot is pushed sideways, the other one is pushed back.
    snap = sim.snapshot()
    sideways = np.einsum("fij,fj->fi", snap.sole_rotation[:, :2, :2], truth.foot_force[:, :2])
    assert sideways[0] == pytest.approx(-sideways[1], abs=0.01)


@pytest.mark.parametrize("rules", [PERFECT, DEFAULT], ids=["perfect", "default"])
def test_cells_and_the_plate_below_them_make_the_grf(world: World, rules: PlantVariation) -> None:
    sim = world.standing(rules)
    found = wrench.foot_wrenches(world.shoe, sim.snapshot().felt)
    assert found[:, 0] == pytest.approx(sim.truth().foot_grf, abs=2e-3)


def test_cells_keep_step_with_the_floor(nao: World) -> None:
    sim = nao.standing(dataclasses.replace(PERFECT, step_s=0.005))
    joints = ("LAnkleRoll", "RAnkleRoll", "LHipRoll", "RHipRoll")
    start = np.array([nao.robot.posture[nao.robot.joint(name)] for name in joints])
    sway = start + np.array([0.06, 0.06, -0.06, -0.06])
    samples = run(sim, JointTrajectory(joints, np.array([0.0, 1.5]), np.array([start, sway])), 100)
    felt = sim.drawn.shoes.parameters.outputs(samples.readings.voltages)
    ahead = wrench.foot_wrenches(nao.shoe, felt)[:, 0, 0] - samples.truth.foot_grf[:, 0]
    rate = np.gradient(samples.truth.foot_grf[:, 0], samples.time)
    assert np.ptp(samples.truth.foot_grf[:, 0]) > 2.0
    assert ahead @ rate / (rate @ rate) == pytest.approx(0.0, abs=0.4 * 0.005)


def test_perfect_cells_find_each_foots_cop(world: World) -> None:
    sim = world.standing(PERFECT)
    found = wrench.foot_wrenches(world.shoe, sim.snapshot().felt)
    assert wrench.cop(found, 1.0) == pytest.approx(sim.truth().foot_cop, abs=1e-4)


def test_perfect_encoders_find_the_cop(world: World) -> None:
    sim = world.standing(PERFECT)
    modelled = world.kinematics.states(sim.joints().angles[None]).cop[0, 0]
    assert modelled == pytest.approx(sim.truth().cop, abs=3e-4)


def test_higher_cells_miss_the_cop_by_height_times_sideways_force(nao: World) -> None:
    height = 0.02
    rules = changed(PERFECT, cells__height_m=height, joints__encoder_error_rad={"LHipRoll": 0.004})
    sim = nao.standing(rules)
    truth = sim.truth()
    found = wrench.cop(wrench.foot_wrenches(nao.shoe, sim.snapshot().felt), 1.0)
    expected = truth.foot_cop + height * truth.foot_force[:, :2] / truth.foot_force[:, 2:]
    assert np.abs(truth.foot_force[:, :2]).max() > 0.5
    # Up to the weight of the plate, that acts at its own height.
    assert found == pytest.approx(expected, abs=1e-4)


def test_clamps_carry_their_share_of_the_moment(nao: World) -> None:
    share = 0.25
    sim = nao.standing(changed(PERFECT, shoes__clamp_share={"left": share}))
    measured = wrench.cop(wrench.foot_wrenches(nao.shoe, sim.snapshot().felt), 1.0)[0]
    centre = nao.shoe.positions[nao.shoe.of_foot(0)].mean(axis=0)
    shrunk = (measured - centre) / (sim.truth().foot_cop[0] - centre)
    # The plate's own weight is added unshrunk; it is small.
    assert shrunk == pytest.approx(np.full(2, 1.0 - share), abs=0.01)


def test_an_encoder_error_appears_as_itself(nao: World) -> None:
    knee = nao.robot.joint("LKneePitch")
    sim = nao.standing(changed(PERFECT, joints__encoder_error_rad={"LKneePitch": 0.02}))
    true = sim.data.qpos[sim.physics.positions]
    off = sim.joints().angles - true
    assert off[knee] == pytest.approx(0.02, abs=1e-5)
    assert np.delete(off, knee) == pytest.approx(np.zeros(len(off) - 1), abs=1e-4)
    # The servo follows its encoder, so the knee is truly straighter than it was told to be.
    assert true[knee] - nao.robot.posture[knee] == pytest.approx(-0.02, abs=6e-3)


def test_a_pushed_gear_gives_way_by_its_compliance_and_half_its_play(nao: World) -> None:
    play, compliance = 0.01, 0.005
    rules = changed(
        PERFECT,
        joints__play_rad={"LKneePitch": play},
        joints__compliance_rad_per_nm={"LKneePitch": compliance},
    )
    sim = nao.standing(rules)
    model, knee = sim.physics.model, nao.robot.joint("LKneePitch")
    torque = sim.joints().efforts[knee]
    assert abs(torque) > 0.3
    given = sim.data.qpos[model.joint("gear/LKneePitch").qposadr[0]]
    # The link falls behind the torque that pushes it.
    assert given == pytest.approx(-np.sign(torque) * play / 2 - compliance * torque, abs=1e-4)


def test_encoders_show_whole_steps(nao: World) -> None:
    step = 0.01
    sim = nao.standing(changed(DEFAULT, joints__encoder_resolution_rad=step))
    steps = sim.joints().angles / step
    assert steps == pytest.approx(np.rint(steps))


def test_joints_of_one_motor_move_together(nao: World) -> None:
    sim = nao.standing(PERFECT)
    sim.command(JointTrajectory(("LHipYawPitch",), np.array([0.0, 2.0]), np.array([[0], [-0.1]])))
    sim.step_to(sim.time + 3.0)
    left, right = (
        sim.data.qpos[sim.physics.positions[nao.robot.joint(name)]]
        for name in ("LHipYawPitch", "RHipYawPitch")
    )
    assert left == pytest.approx(-0.1, abs=0.01)
    assert right == pytest.approx(left, abs=1e-3)
    efforts = sim.joints().efforts
    assert efforts[nao.robot.joint("LHipYawPitch")] == efforts[nao.robot.joint("RHipYawPitch")]


def test_torque_limits_hold(world: World) -> None:
    factor = 0.4
    sim = world.standing(changed(DEFAULT, servo__torque_limit_factor=factor))
    limits = factor * world.robot.effort_limit * (1.0 + 1e-9)
    sim.command(lean(world, 0.15, 0.05))
    efforts = []
    for _ in range(100):
        sim.step_to(sim.time + 0.01)
        efforts.append(sim.joints().efforts)
    assert (np.abs(efforts) <= limits).all()
    reached = (np.max(np.abs(efforts), axis=0) > 0.999 * limits)[world.robot.legs]
    assert reached.any()


def test_motors_warm_up_with_the_square_of_their_torque(nao: World) -> None:
    rules = changed(DEFAULT, servo__temperature_time_s=0.5)
    sim = nao.standing(rules)
    sim.step_to(sim.time + 5.0)
    joints, servo = sim.joints(), rules.servo
    load = joints.efforts / nao.robot.effort_limit
    expected = servo.ambient_degc + servo.temperature_rise_degc * load**2
    knees = [nao.robot.joint(name) for name in ("LKneePitch", "RKneePitch")]
    assert joints.temperatures[knees] == pytest.approx(expected[knees], rel=0.02)
    assert joints.temperatures[knees].min() > servo.ambient_degc + 1.0


def samples(world: World, rules: PlantVariation, rate: float = 100.0) -> SimulatedSamples:
    return run(world.standing(rules), lean(world, 0.04), rate)


def test_a_seed_gives_the_same_motion_and_readings(nao: World) -> None:
    one, same = (samples(nao, DEFAULT) for _ in range(2))
    assert (one.readings.counts == same.readings.counts).all()
    assert (one.joints.angles == same.joints.angles).all()
    assert (one.truth.cop == same.truth.cop).all()
    assert np.ptp(one.truth.cop[:, 0]) > 0.005


def test_looking_more_often_changes_nothing(world: World) -> None:
    often, seldom = samples(world, DEFAULT, 400.0), samples(world, DEFAULT, 100.0)
    assert often.time[::4] == pytest.approx(seldom.time)
    assert often.truth.foot_force[::4] == pytest.approx(seldom.truth.foot_force, abs=1e-9)
    assert (often.joints.angles[::4] == seldom.joints.angles).all()


def test_it_does_what_it_is_told_and_holds_the_end(world: World) -> None:
    sim, planned = world.standing(DEFAULT), lean(world, 0.04)
    run(sim, planned, 50.0, hold=1.0)
    columns = [world.robot.joint(name) for name in planned.names]
    assert sim.joints().angles[columns] == pytest.approx(planned.positions[-1], abs=0.01)
    before = sim.truth().cop
    sim.step_to(sim.time + 1.0)
    assert sim.truth().cop == pytest.approx(before, abs=2e-4)


def test_samples_are_what_single_looks_give(nao: World) -> None:
    planned = lean(nao, 0.03)
    together = run(nao.standing(DEFAULT), planned, 20.0, hold=0.0)
    sim = nao.standing(DEFAULT)
    start = sim.time
    sim.command(planned)
    for index in range(len(together.time)):
        sim.step_to(start + index / 20.0)
        assert together.time[index] == sim.time
        assert (sim.readings().counts == together.readings.counts[index]).all()
        assert (sim.joints().angles == together.joints.angles[index]).all()
        assert sim.truth().cop == pytest.approx(together.truth.cop[index])


def test_late_readings_are_the_ones_of_before(nao: World) -> None:
    late = changed(DEFAULT, Latency(("left",), 0.1), cells__noise_std_n=0.0)
    now, then = samples(nao, changed(DEFAULT, cells__noise_std_n=0.0)), samples(nao, late)
    left, right = nao.shoe.of_foot(0), nao.shoe.of_foot(1)
    assert (then.readings.counts[:, right] == now.readings.counts[:, right]).all()
    assert then.readings.voltages[10:, left] == pytest.approx(
        now.readings.voltages[:-10, left], abs=1e-9
    )
    assert np.abs(then.readings.voltages - now.readings.voltages)[:, left].max() > 0.01


def test_a_sloping_floor_moves_the_cop_by_the_height_of_the_com(nao: World) -> None:
    about_x, about_y = 0.02, -0.01
    sim = nao.standing(changed(PERFECT, FloorTilt(about_x, about_y)))
    com, truth = com_in_left_sole(sim), sim.truth()
    slope = np.array([np.tan(about_y), -np.tan(about_x)])
    assert truth.cop == pytest.approx(com[:2] + com[2] * slope, abs=1e-4)
    assert truth.grf == pytest.approx(sim.weight * np.cos(about_x) * np.cos(about_y), abs=2e-3)


def test_soles_that_cannot_be_flat_are_refused(world: World) -> None:
    sim = world.standing(DEFAULT)
    before = sim.snapshot()
    angles = world.robot.posture.copy()
    angles[world.robot.legs[3]] += 0.3
    with pytest.raises(SupportNotReachedError, match="mm apart in height and"):
        sim.place(angles)
    after = sim.snapshot()
    assert after.time == before.time
    assert (after.felt == before.felt).all()


def test_no_rest_in_time_is_said(nao: World) -> None:
    with pytest.raises(SupportNotReachedError, match=r"does not come to rest within 0\.3 s"):
        nao.simulate(DEFAULT).place(nao.robot.posture, patience=0.3)


def test_a_fall_is_said(world: World) -> None:
    sim = world.standing(DEFAULT)
    assert sim.upright
    with pytest.raises(RobotFellError, match=r"fell at .* s \(soles tilted") as caught:
        run(sim, lean(world, 0.6, 0.5), 100.0, hold=2.0)
    assert not sim.upright
    assert caught.value.time == sim.time
    sim.place(world.robot.posture)
    assert sim.upright


def test_a_torso_that_leans_as_commanded_has_not_fallen(nao: World) -> None:
    sim = nao.standing(DEFAULT)
    angles = nao.robot.posture.copy()
    angles[[nao.robot.joint(name) for name in ("LHipPitch", "RHipPitch")]] -= 1.0
    sim.reset(angles)
    assert sim.data.body(sim.drawn.body.links[0]).xmat[8] < np.cos(0.9)
    assert sim.upright


def test_placing_too_weak_a_robot_ends_in_a_fall(nao: World) -> None:
    with pytest.raises((RobotFellError, SupportNotReachedError)):
        nao.standing(changed(DEFAULT, servo__torque_limit_factor=0.05))


def test_impossible_calls_are_refused(nao: World) -> None:
    sim = nao.standing(DEFAULT)
    with pytest.raises(ShapeError, match="joint angles"):
        sim.place(np.zeros(3))
    with pytest.raises(ShoecalError, match="not finite"):
        sim.place(np.full(len(nao.robot.posture), np.nan))
    with pytest.raises(ShoecalError, match="0 Hz gives no samples"):
        run(sim, lean(nao, 0.01), 0.0)


def test_time_is_the_last_step_not_after_what_was_asked(nao: World) -> None:
    sim = nao.simulate(dataclasses.replace(DEFAULT, step_s=0.002))
    for asked, reached in ((0.0, 0.0), (0.0019, 0.0), (0.0301, 0.03), (0.01, 0.03)):
        sim.step_to(asked)
        assert sim.time == pytest.approx(reached)


def test_the_root_stands_where_the_model_says(world: World) -> None:
    sim = world.standing(PERFECT)
    snap = sim.snapshot()
    com = world.kinematics.states(sim.joints().angles[None]).com[0, 0]
    assert com_in_left_sole(sim) == pytest.approx(com, abs=1e-4)
    assert snap.base_orientation == pytest.approx([0.0, 0.0, 0.0, 1.0], abs=0.2)
    assert snap.base_position[2] > 0.2


def test_a_squat_of_a_base_frame_near_the_floor_is_no_fall(nao: World, tmp_path: Path) -> None:
    above = float(nao.standing(PERFECT).snapshot().base_position[2])
    frame = (
        '<link name="ground"/><joint name="ground" type="fixed"><parent link="ground"/>'
        f'<child link="base_link"/><origin xyz="0 0 {above - 0.02}"/></joint></robot>'
    )
    urdf = tmp_path / "nao.urdf"
    urdf.write_text(nao.robot.urdf.read_text().replace("</robot>", frame))
    robot = load_robot(nao.robot.path, nao.shoe, urdf=urdf)
    sim = World(robot, nao.shoe, Kinematics(robot)).standing(PERFECT)
    assert sim.snapshot().base_position[2] == pytest.approx(0.02, abs=5e-3)
    names = tuple(
        f"{side}{joint}" for side in "LR" for joint in ("HipPitch", "KneePitch", "AnklePitch")
    )
    start = np.array([robot.posture[robot.joint(name)] for name in names])
    squat = start + np.tile([-0.2, 0.4, -0.2], 2)
    run(sim, JointTrajectory(names, np.array([0.0, 3.0]), np.array([start, squat])), 100.0)
    assert sim.snapshot().base_position[2] < 0.01
    assert sim.upright
