"""Effects that are none of the library's, as a benchmark makes them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import pytest

from core.simulation.test_disturbances import standing_still
from core.simulation.worlds import PERFECT, World, changed
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.simulation.disturbances import Disturbance, MovingRobot
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.sampled_parts import link_names
from shoecal_core.simulation.samples import run
from shoecal_core.simulation.shoe_physics import sole_name


@dataclass(frozen=True)
class Hanger(Effect):
    """A cable of the room that holds part of the root's weight, as a spring of the physics."""

    force: float

    def on_spec(self, spec: mujoco.MjSpec, robot: Robot) -> None:  # noqa: ARG002
        root = spec.worldbody.first_body()
        root.add_site(name="hook")
        spec.worldbody.add_site(name="ceiling", pos=[0.0, 0.0, 50.0])
        # So long and soft that the force hardly depends on where the robot is.
        cable = spec.add_tendon(
            name="cable", stiffness=[self.force / 1000.0, 0.0, 0.0], springlength=[-950.0, -950.0]
        )
        cable.wrap_site("hook")
        cable.wrap_site("ceiling")


@dataclass(frozen=True)
class Pebble(Effect):
    """Something small sticks below the middle of a sole."""

    foot: int
    radius: float

    def on_spec(self, spec: mujoco.MjSpec, robot: Robot) -> None:
        sole = spec.body(sole_name(self.foot))
        outline = robot.feet[self.foot].outline
        middle = (outline.min(axis=0) + outline.max(axis=0)) / 2.0
        sole.add_geom(
            type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[self.radius, 0.0, 0.0],
            pos=[*middle, 0.0], mass=0.0, contype=1, conaffinity=2,
        )  # fmt: skip


@dataclass(frozen=True)
class Rubbing(Effect):
    """A force on the root that grows with the run, and knows which run it is."""

    rate: float

    def disturbances(self) -> Sequence[Disturbance]:
        return [Pull(self.rate)]


@dataclass
class Pull:
    rate: float

    def act(self, sim: MovingRobot, time: float) -> None:
        root = sim.physics.model.body(link_names(sim.robot)[0]).id
        sim.data.xfrc_applied[root, 2] += self.rate * max(time, 0.0) * sim.run


def test_a_spring_of_the_room_carries_its_part(world: World) -> None:
    sim = world.standing(changed(PERFECT, Hanger(3.0)))
    sim.step_to(sim.time + 1.0)
    assert sim.truth().grf == pytest.approx(sim.weight - 3.0, abs=0.05)


def test_a_shoe_that_rests_on_a_pebble_is_tilted_and_its_cells_tell_the_cop(nao: World) -> None:
    sim = nao.standing(changed(PERFECT, Pebble(0, 0.003)))
    snap, truth = sim.snapshot(), sim.truth()
    assert snap.sole_position[0, 2] - snap.sole_position[1, 2] > 5e-4
    assert truth.grf == pytest.approx(sim.weight, abs=0.05)


def test_forces_act_from_the_runs_begin_on_and_end_with_it(nao: World) -> None:
    sim = nao.standing(changed(PERFECT, Rubbing(-1.0)))
    assert sim.truth().grf == pytest.approx(sim.weight, abs=0.01)
    for number in (1, 2):
        samples = run(sim, standing_still(sim, 2.0), 50.0, hold=0.5)
        time = samples.time - samples.time[0]
        more = samples.truth.grf - sim.weight
        assert more[time > 1.0] == pytest.approx(number * time[time > 1.0], abs=0.1)
        sim.place(nao.robot.posture)
    assert sim.weight == pytest.approx((sim.drawn.body.mass + nao.shoe.mass) * GRAVITY, abs=1e-3)


def test_each_robot_has_disturbances_of_its_own(nao: World) -> None:
    rules = changed(PERFECT, Rubbing(-1.0))
    one, other = nao.standing(rules), nao.standing(rules)
    run(one, standing_still(one, 1.0), 50.0)
    assert other.run == 0
    other.step_to(other.time + 1.0)
    assert other.truth().grf == pytest.approx(other.weight, abs=0.01)
