"""Effects of the sensors in a whole simulated robot."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest

from core.simulation.effects.chains import item
from core.simulation.worlds import DEFAULT, World, changed, load_world
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.samples import SimulatedSamples, run

QUIET = changed(DEFAULT, cells__noise_std_n=0.0)
SHOES = dataclasses.replace(QUIET.shoes, warm_up_k=5.0, temperature_told=True)
WARM = dataclasses.replace(QUIET, shoes=SHOES)
FL, RR = "left/front_left", "left/rear_right"

EFFECTS: dict[str, tuple[Effect, list[int]]] = {
    "nonlinearity": (item("nonlinearity", FL, quadratic_per_n=0.003, cubic_per_n2=1e-4), [0]),
    "saturation": (item("saturation", FL, level_n=5.0), [0]),
    "hysteresis": (item("hysteresis", "left", fraction=0.05), [0, 1, 2, 3]),
    "creep": (item("creep", FL, fraction=0.05, time_s=2.0), [0]),
    "zero_offset": (item("zero_offset", "right", offset_n=0.5, run=1), [4, 5, 6, 7]),
    "zero_drift": (item("zero_drift", "right", rate_n_per_s=0.02), [4, 5, 6, 7]),
    "span_drift": (item("span_drift", FL, rate_per_s=0.005), [0]),
    "stuck_cell": (item("stuck_cell", FL, share=1.0, time_s=1.5), [0]),
    "swapped_cells": (item("swapped_cells", FL, RR), [0, 3]),
    "crosstalk": (item("crosstalk", FL, RR, fraction=0.1), [0]),
    "off_axis_load": (item("off_axis_load", "left", x=0.3, y=0.3), [0, 1, 2, 3]),
    "latency": (item("latency", "left", delay_s=0.1), [0, 1, 2, 3]),
    "low_pass": (item("low_pass", "left", time_s=0.1), [0, 1, 2, 3]),
}


def swing(world: World, seconds: float) -> JointTrajectory:
    """From side to side, two seconds there and back."""
    names = ("LAnkleRoll", "RAnkleRoll", "LHipRoll", "RHipRoll")
    start = world.robot.posture[[world.robot.joint(name) for name in names]]
    times = np.linspace(0.0, seconds, round(40 * seconds) + 1)
    way = 0.05 * np.sin(np.pi * times)[:, None] * np.array([1.0, 1.0, -1.0, -1.0])
    return JointTrajectory(names, times, start + way)


def recorded(sim: SimulatedRobot, rate: float = 100.0) -> tuple[SimulatedSamples, FloatArray]:
    """A short motion, and what its readings tell by the true affine law [N]."""
    samples = run(sim, swing(load_world("nao"), 4.0), rate)
    return samples, sim.drawn.shoes.parameters.outputs(samples.readings.voltages)


@cache
def plain() -> FloatArray:
    """Readings without an effect."""
    return recorded(load_world("nao").standing(WARM))[1]


@pytest.mark.parametrize("name", EFFECTS)
def test_an_effect_changes_the_readings_where_it_sits_alone(nao: World, name: str) -> None:
    effect, places = EFFECTS[name]
    samples, told = recorded(nao.standing(changed(WARM, effect)))
    off = np.abs(told - plain()).max(axis=0)
    assert (off[places] > 0.02).all()
    others = [index for index in range(8) if index not in places]
    assert off[others] == pytest.approx(np.zeros(len(others)), abs=1e-4)
    assert not samples.readings.status.any()


def test_readings_together_are_single_looks_with_every_effect(nao: World) -> None:
    rules = changed(DEFAULT, *(effect for effect, _ in EFFECTS.values()))
    rules = dataclasses.replace(rules, shoes=SHOES)
    together, _ = recorded(nao.standing(rules), 40.0)
    sim = nao.standing(rules)
    start, command = sim.time, swing(nao, 4.0)
    sim.begin_run()
    for index in range(len(together.time)):
        sim.step_to(start + index / 40.0)
        if index == 20:
            sim.command(command)
        one = sim.readings()
        assert (one.counts == together.readings.counts[index]).all()
        assert one.temperature == together.readings.temperature[index]


def test_effects_do_not_depend_on_how_often_one_looks(nao: World) -> None:
    rules = changed(WARM, *(effect for effect, _ in EFFECTS.values()))
    _, often = recorded(nao.standing(rules), 400.0)
    _, seldom = recorded(nao.standing(rules), 50.0)
    assert often[::8] == pytest.approx(seldom, abs=1e-4)


def test_a_sessions_time_goes_on_when_the_robot_is_put_down_again(nao: World) -> None:
    rules = changed(QUIET, item("zero_drift", "all", rate_n_per_s=0.1))
    sim, level = nao.standing(rules), nao.standing(QUIET)
    for _ in range(2):
        for one in (sim, level):
            one.step_to(one.time + 2.0)
            one.place(nao.robot.posture)
    assert sim.session_time > 4.0 + sim.time
    drifted = sim.snapshot().felt - level.snapshot().felt
    assert drifted == pytest.approx(np.full(8, 0.127 * sim.session_time), rel=0.02)


def test_a_device_tells_the_temperature_of_the_shoes(nao: World) -> None:
    sim = nao.standing(WARM)
    sim.step_to(sim.time + 5.0)
    warmer = 5.0 * (1.0 - np.exp(-sim.session_time / WARM.shoes.warm_up_time_s))
    assert sim.readings().temperature == pytest.approx(WARM.servo.ambient_degc + warmer)
    assert np.isnan(nao.standing(QUIET).readings().temperature)
