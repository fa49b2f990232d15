"""What befalls the simulated robot shows in the floor's forces."""

from __future__ import annotations

import numpy as np
import pytest

from core.simulation.worlds import PERFECT, World
from shoecal_core.errors import NameNotFoundError
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.simulation.disturbances import Push
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_parts import link_names
from shoecal_core.simulation.samples import run


def standing_still(sim: SimulatedRobot, seconds: float) -> JointTrajectory:
    angles = sim.joints().angles
    return JointTrajectory(sim.robot.joint_names, np.array([0.0, seconds]), np.stack((angles,) * 2))


def test_whoever_holds_the_robot_carries_that_much_of_it(world: World) -> None:
    sim = world.standing(PERFECT)
    held = Push(link_names(world.robot)[0], np.array([0.0, 0.0, 4.0]), 0.5, 1.5)
    samples = run(sim, standing_still(sim, 2.0), 50.0, hold=0.5, disturbances=[held])
    time, grf = samples.time - samples.time[0], samples.truth.grf
    during, after = (time > 1.2) & (time < 1.5), time > 2.5
    assert grf[during].mean() == pytest.approx(sim.weight - 4.0, abs=0.05)
    assert grf[after].mean() == pytest.approx(sim.weight, abs=0.05)


def test_two_pushes_on_one_link_add_up(world: World) -> None:
    sim = world.standing(PERFECT)
    link = link_names(world.robot)[0]
    pushes = [Push(link, np.array([0.0, 0.0, -2.0]), 0.0, 9.0) for _ in range(2)]
    samples = run(sim, standing_still(sim, 1.0), 50.0, disturbances=pushes)
    assert samples.truth.grf[-10:].mean() == pytest.approx(sim.weight + 4.0, abs=0.05)


def test_a_link_that_there_is_not(world: World) -> None:
    sim = world.standing(PERFECT)
    with pytest.raises(NameNotFoundError, match="no link named 'tail'"):
        Push("tail", np.zeros(3), 0.0, 1.0).act(sim, 0.5)


def test_what_befalls_one_run_is_over_with_it(world: World) -> None:
    sim = world.standing(PERFECT)
    push = Push(link_names(world.robot)[0], np.array([0.0, 0.0, -2.0]), 0.0, 1e9)
    run(sim, standing_still(sim, 0.2), 50.0, disturbances=[push])
    assert sim.run == 1
    after = run(sim, standing_still(sim, 1.0), 50.0)
    assert sim.run == 2
    assert after.truth.grf[-10:].mean() == pytest.approx(sim.weight, abs=0.05)


def test_a_run_begins_when_it_is_begun(world: World) -> None:
    sim = world.standing(PERFECT)
    assert sim.run_time == -np.inf
    sim.begin_run(number=4)
    begun = sim.time
    sim.step_to(begun + 0.5)
    assert sim.run == 4
    assert sim.run_time == pytest.approx(0.5)
