"""Motions on both feet in the physics: load, grip, tilt and flat soles as planned.

Gears give, encoders and masses are off; nothing of the estimator or the planner is in there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

from core.planning.motions import planner_of
from core.simulation.worlds import DEFAULT, load_world
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.motion import Motion
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.workflows.simulated_session import take

WIDE = {
    "nao": DoubleSupport(0.04, -0.136, 0.312),
    "odd_biped": DoubleSupport(0.03, -0.13, -0.2),
}
FLOOR_FRICTION = 0.9


@dataclass(frozen=True)
class Followed:
    """A plan, and N looks at the true robot while it followed.

    Attributes:
        planned: (N, 2) shares of the weight on left, right that the check expects.
        force: (N, 2, 3) of the floor on left, right [N].
        weight: of the true robot [N].
        tilts: (N, 3) of the soles and the torso against the vertical [rad].
        tilt_max: of the torso, as the robot file has it [rad].
    """

    planned: FloatArray
    force: FloatArray
    weight: float
    tilts: FloatArray
    tilt_max: float


@cache
def followed(name: str) -> Followed:
    world, planner = load_world(name), planner_of(name)
    sim = world.simulate(DEFAULT, seed=4)
    sim.place(planner.stance(WIDE[name]))
    plan = planner.plan_from(sim.joints().angles, "landmarks")
    force, tilts, times = [], [], []

    def look(_: Motion, since: float) -> None:
        snap = sim.snapshot()
        x, y = snap.base_orientation[:2]
        up = [*snap.sole_rotation[:, 2, 2], 1.0 - 2.0 * (x * x + y * y)]
        force.append(snap.contact[:, :3])
        tilts.append(np.arccos(np.clip(up, -1.0, 1.0)))
        times.append(since)

    take(sim, plan, look)
    loads = track(planner.legs.robot, plan.positions).loads / planner.legs.robot.weight
    planned = np.column_stack([np.interp(times, plan.time, load) for load in loads.T])
    return Followed(
        planned, np.array(force), sim.weight, np.array(tilts), planner.legs.robot.tilt_max
    )


@pytest.mark.parametrize("name", WIDE)
def test_each_foot_keeps_the_load_that_was_planned(name: str) -> None:
    seen = followed(name)
    share = seen.force[..., 2] / seen.weight
    assert seen.planned.min() > 0.1
    assert share.min() > 0.1
    assert np.abs(share - seen.planned).max() < 0.06


@pytest.mark.parametrize("name", WIDE)
def test_no_sole_rolls_or_slides_and_the_torso_stays_upright(name: str) -> None:
    seen = followed(name)
    sideways = np.linalg.norm(seen.force[..., :2], axis=-1) / seen.force[..., 2]
    assert sideways.max() < 0.8 * FLOOR_FRICTION
    assert seen.tilts[:, :2].max() < 0.004
    assert seen.tilts[:, 2].max() < seen.tilt_max + 0.01
