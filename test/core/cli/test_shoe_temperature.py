"""What a simulated session tells of the temperature of the shoes."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from core.simulation.worlds import DEFAULT, World, load_world
from shoecal_core.planning.motion_sets import PlannedRun
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.samples import run
from shoecal_core.workflows.simulated_recording import record_run


def recorded(world: World, rules: PlantVariation, folder: Path) -> Run:
    """Three seconds of standing."""
    sim = world.standing(rules)
    robot = world.robot
    still = JointTrajectory(
        robot.joint_names, np.array([0.0, 2.0]), np.tile(sim.joints().angles, (2, 1))
    )
    session = Session.create(folder, robot.path, robot.urdf, world.shoe.path, seed=1)
    samples = run(sim, still, 50.0)
    planned = PlannedRun(DoubleSupport(0.0, -0.1, 0.0), "hold")
    record_run(session, sim, planned, still, samples, start_ns=10**9, hold=0.5)
    return Session.open(folder).read(1)


def test_a_device_that_tells_it_is_recorded_and_another_is_not(tmp_path: Path) -> None:
    nao = load_world("nao")
    shoes = dataclasses.replace(
        DEFAULT.shoes, warm_up_k=50.0, warm_up_time_s=20.0, temperature_told=True
    )
    warm = recorded(nao, dataclasses.replace(DEFAULT, shoes=shoes), tmp_path / "warm")
    assert warm.shoe_temperature is not None
    told, ambient = warm.shoe_temperature.value, DEFAULT.servo.ambient_degc
    assert len(told) == 4
    assert (np.diff(told) > 1.0).all()
    assert told[0] > ambient
    assert warm.readings is not None
    assert warm.readings.temperature[0] == pytest.approx(np.full(8, told[0]))
    silent = recorded(nao, DEFAULT, tmp_path / "silent")
    assert silent.shoe_temperature is None
    assert silent.readings is not None
    assert np.isnan(silent.readings.temperature).all()
