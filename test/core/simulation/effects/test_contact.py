"""Floor that gives: the shoe tilts by the moment on it times the compliance."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from core.simulation.effects.chains import item
from core.simulation.test_robot_physics import six_axis_world
from core.simulation.worlds import DEFAULT, PERFECT, World, changed
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.shoe import wrench
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw_shoes


def lean(sim: SimulatedRobot, angle: float) -> None:
    """The whole body forward, and rest."""
    robot = sim.robot
    names = [robot.joint_names[index] for index in robot.legs]
    ankles = tuple(name for name in names if "ankle" in name.lower() and "itch" in name)
    start = np.array([robot.posture[robot.joint(name)] for name in ankles])
    positions = np.array([start, start + angle])
    sim.command(JointTrajectory(ankles, np.array([0.0, 2.0]), positions))
    sim.step_to(sim.time + 3.5)


def tilt_and_moment(sim: SimulatedRobot, foot: int) -> tuple[FloatArray, FloatArray]:
    """Tilt (2,) of a shoe about x, y of its sole [rad], and the moment it loads the floor with."""
    snap, truth = sim.snapshot(), sim.truth()
    rotation = snap.sole_rotation[foot]
    yaw = np.arctan2(rotation[1, 0], rotation[0, 0])
    turn = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    tilt = turn @ np.array([-rotation[1, 2], rotation[0, 2]])
    outline = sim.robot.feet[foot].outline
    middle = (outline.min(axis=0) + outline.max(axis=0)) / 2.0
    x, y = truth.foot_cop[foot] - middle
    return tilt, truth.foot_grf[foot] * np.array([-y, x])


@pytest.mark.parametrize("rules", [PERFECT, DEFAULT], ids=["perfect", "default"])
@pytest.mark.parametrize("compliance", [0.001, 0.008])
def test_a_shoe_tilts_in_soft_floor_by_moment_times_compliance(
    world: World, rules: PlantVariation, compliance: float
) -> None:
    sim = world.standing(
        changed(rules, item("soft_ground", "left", compliance_rad_per_nm=compliance))
    )
    for angle in (0.02, -0.02):
        lean(sim, angle)
        tilt, moment = tilt_and_moment(sim, 0)
        assert np.abs(moment).max() > 0.05
        assert tilt == pytest.approx(compliance * moment, rel=0.01, abs=3e-5)
        # The other one stands on hard floor.
        assert np.abs(tilt_and_moment(sim, 1)[0]).max() < 1e-4
    assert sim.truth().grf == pytest.approx(sim.weight, abs=0.01)


def test_soft_floor_sinks_and_is_not_heavy(nao: World) -> None:
    soft = nao.standing(changed(PERFECT, item("soft_ground", "all", compliance_rad_per_nm=0.004)))
    hard = nao.standing(PERFECT)
    assert soft.weight == pytest.approx(hard.weight)
    deep = hard.snapshot().sole_position[:, 2] - soft.snapshot().sole_position[:, 2]
    assert (deep > 1e-4).all()
    found = wrench.cop(wrench.foot_wrenches(nao.shoe, soft.snapshot().felt), 1.0)
    assert found == pytest.approx(soft.truth().foot_cop, abs=2e-4)


def test_six_axis_feet_stand_on_soft_floor(tmp_path: Path) -> None:
    world = six_axis_world(tmp_path)
    sim = world.standing(changed(PERFECT, item("soft_ground", "all", compliance_rad_per_nm=0.004)))
    for foot in (0, 1):
        tilt, moment = tilt_and_moment(sim, foot)
        assert tilt == pytest.approx(0.004 * moment, rel=0.01, abs=3e-5)
    found = wrench.foot_wrenches(world.shoe, sim.snapshot().felt)
    assert found[:, 0] == pytest.approx(sim.truth().foot_grf, abs=6e-3)


def test_compliances_of_a_foot_add_up(nao: World) -> None:
    rules = changed(
        PERFECT,
        item("soft_ground", "left", compliance_rad_per_nm=0.001),
        item("soft_ground", "all", compliance_rad_per_nm=0.002),
    )
    shoes = draw_shoes(rules, nao.shoe, 1)
    assert shoes.ground_compliance == pytest.approx([0.003, 0.002])


def test_a_slope_has_no_place() -> None:
    item("floor_tilt", about_x_rad=0.01, about_y_rad=0.0)
    with pytest.raises(FileError, match="location: names nothing, for the floor has one slope"):
        item("floor_tilt", "left", about_x_rad=0.01, about_y_rad=0.0)


def test_inertia_is_always_there(nao: World) -> None:
    one, other = (nao.standing(rules) for rules in (PERFECT, changed(PERFECT, item("inertia"))))
    assert (one.snapshot().felt == other.snapshot().felt).all()
    item("inertia", factor=1.0)
    with pytest.raises(FileError, match="factor: must be at least 1 and at most 1"):
        item("inertia", factor=0.5)
