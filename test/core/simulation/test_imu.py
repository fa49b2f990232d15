"""The inertial sensor against the root link's true motion, seen through the physics."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.simulation.worlds import DEFAULT, PERFECT, World, changed
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.simulation.effects.contact import FloorTilt
from shoecal_core.simulation.samples import SimulatedSamples, run
from shoecal_core.simulation.snapshot import stack


def lean(world: World) -> SimulatedSamples:
    """Both ankles pitched to and fro in one second."""
    robot = world.robot
    names = [robot.joint_names[index] for index in robot.legs]
    ankles = tuple(name for name in names if "ankle" in name.lower() and "itch" in name)
    start = np.array([robot.posture[robot.joint(name)] for name in ankles])
    positions = start + np.array([[0.0], [0.04], [0.0]])
    trajectory = JointTrajectory(ankles, np.array([0.0, 0.5, 1.0]), positions)
    return run(world.standing(PERFECT), trajectory, 400.0, hold=0.2)


def test_at_rest_it_feels_the_floors_push_and_the_slope(nao: World) -> None:
    about_x, about_y = 0.02, -0.01
    told = nao.standing(changed(PERFECT, FloorTilt(about_x, about_y))).imu()
    level = nao.standing(PERFECT).imu()
    assert told is not None
    assert level is not None
    assert level.linear_acceleration == pytest.approx([0.0, 0.0, GRAVITY], abs=0.3)
    for one in (told, level):
        up = Rotation.from_quat(one.orientation).apply(one.linear_acceleration)
        assert up == pytest.approx([0.0, 0.0, GRAVITY], abs=1e-3)
        assert one.angular_velocity == pytest.approx(np.zeros(3), abs=1e-3)
    turn = Rotation.from_quat(told.orientation) * Rotation.from_quat(level.orientation).inv()
    assert turn.as_rotvec()[:2] == pytest.approx([about_x, about_y], abs=1e-3)


def test_in_motion_it_tells_the_derivatives_of_the_pose(nao: World) -> None:
    samples = lean(nao)
    assert samples.imu is not None
    step = samples.time[1] - samples.time[0]
    turn = Rotation.from_quat(samples.imu.orientation)
    rate = (turn[:-1].inv() * turn[1:]).as_rotvec() / step
    assert np.abs(rate).max() > 0.05
    assert np.abs(samples.imu.angular_velocity[:-1] - rate).max() < 0.05 * np.abs(rate).max()
    speed = np.diff(samples.base_position, axis=0) / step
    felt = turn.apply(samples.imu.linear_acceleration) - [0.0, 0.0, GRAVITY]
    # Over half a second, in which single steps' contact chatter averages out.
    span = round(0.25 / step)
    gained = speed[span:] - speed[:-span]
    summed = np.cumsum(felt[1:-1], axis=0) * step
    found = summed[span - 1 :][: len(gained)] - np.vstack([np.zeros(3), summed[: len(gained) - 1]])
    assert np.abs(gained).max() > 0.01
    assert found == pytest.approx(gained, abs=0.05 * np.abs(gained).max())


def test_mounting_and_noise_have_the_spread_that_is_asked_for(nao: World) -> None:
    imu = dataclasses.replace(
        DEFAULT.imu, mounting_error_std_rad=0.01, orientation_std_rad=0.002,
        gyro_std_rad_per_s=0.003, accelerometer_std_mps2=0.04,
    )  # fmt: skip
    sim = nao.standing(dataclasses.replace(DEFAULT, imu=imu))
    told = sim.imu(stack([sim.snapshot()] * 2000))
    assert told is not None
    mounting = Rotation.from_rotvec(sim.drawn.body.imu_mounting)
    true = Rotation.from_quat(sim.snapshot().base_orientation) * mounting
    off = (true.inv() * Rotation.from_quat(told.orientation)).as_rotvec()
    assert off.mean(axis=0) == pytest.approx(np.zeros(3), abs=2e-4)
    assert off.std(axis=0) == pytest.approx(np.full(3, 0.002), rel=0.1)
    assert told.angular_velocity.std(axis=0) == pytest.approx(np.full(3, 0.003), rel=0.1)
    assert told.linear_acceleration.std(axis=0) == pytest.approx(np.full(3, 0.04), rel=0.1)


def test_looking_at_it_changes_no_other_reading(nao: World) -> None:
    looked, other = (nao.standing(DEFAULT) for _ in range(2))
    looked.imu()
    assert (looked.readings().counts == other.readings().counts).all()


def test_many_instants_read_as_single_ones(nao: World) -> None:
    one, other = (nao.standing(DEFAULT) for _ in range(2))
    together = one.imu(stack([one.snapshot()] * 3))
    single = [other.imu() for _ in range(3)]
    assert together is not None
    for index, reading in enumerate(single):
        assert reading is not None
        assert together.orientation[index] == pytest.approx(reading.orientation)
        assert (together.linear_acceleration[index] == reading.linear_acceleration).all()


def test_a_robot_without_it_tells_nothing(nao: World) -> None:
    rules = dataclasses.replace(PERFECT, imu=dataclasses.replace(PERFECT.imu, present=False))
    assert nao.standing(rules).imu() is None
