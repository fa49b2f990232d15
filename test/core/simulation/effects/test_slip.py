"""A foot that slips comes to rest where it is said to."""

from __future__ import annotations

import numpy as np
import pytest

from core.simulation.effects.chains import item
from core.simulation.test_disturbances import standing_still
from core.simulation.worlds import DEFAULT, PERFECT, World, changed
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import FileError
from shoecal_core.simulation.effects.slip import DURATION, Slip
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.samples import run
from shoecal_core.simulation.shoe_physics import tip_geoms

_START = 0.5


def soles(sim: SimulatedRobot) -> FloatArray:
    """(2, 3) places of the soles on the floor and their yaw [m, m, rad]."""
    snap = sim.snapshot()
    yaw = np.arctan2(snap.sole_rotation[:, 1, 0], snap.sole_rotation[:, 0, 0])
    return np.column_stack((snap.sole_position[:, :2], yaw))


def in_sole(before: FloatArray, after: FloatArray) -> FloatArray:
    """(3,) a sole's way from before to after, in its own frame before."""
    way = after - before
    c, s = np.cos(before[2]), np.sin(before[2])
    return np.array([c * way[0] + s * way[1], -s * way[0] + c * way[1], way[2]])


@pytest.mark.parametrize("foot", ["left", "right"])
@pytest.mark.parametrize(
    "shift", [(0.006, 0.0, 0.0), (-0.003, 0.004, 0.0), (0.002, 0.0, 0.02)], ids=str
)
def test_a_foot_that_slipped_stays_where_its_leg_moved_it(
    world: World, foot: str, shift: tuple[float, float, float]
) -> None:
    dx, dy, dtheta = shift
    slip = item("slip", foot, dx_m=dx, dy_m=dy, dtheta_rad=dtheta, time_s=_START, run=1)
    sim = world.standing(changed(DEFAULT, slip))
    index = ("left", "right").index(foot)
    before = soles(sim)
    samples = run(sim, standing_still(sim, 2.5), 50.0)
    after = soles(sim)
    way = in_sole(before[index], after[index])
    assert way[:2] == pytest.approx([dx, dy], abs=0.02 * np.hypot(dx, dy) + 4e-4)
    assert way[2] == pytest.approx(dtheta, abs=3e-3)
    assert np.abs(after[1 - index] - before[1 - index])[:2].max() < 1.5e-3
    time = samples.time - samples.time[0]
    moved = np.linalg.norm(samples.sole_position[:, index, :2] - before[index, :2], axis=1)
    assert moved[time < _START].max() < 2e-4
    assert moved[time > _START + DURATION][0] > 0.8 * np.hypot(dx, dy)


def test_it_slips_in_its_run_alone(nao: World) -> None:
    slip = item("slip", "left", dx_m=0.005, time_s=0.3, run=2)
    sim = nao.standing(changed(DEFAULT, slip))
    for number, moves in ((1, False), (2, True), (3, False)):
        if number > 1:
            sim.place(nao.robot.posture)
        before = soles(sim)[0]
        run(sim, standing_still(sim, 1.0), 50.0)
        assert sim.run == number
        assert (in_sole(before, soles(sim)[0])[0] > 0.004) == moves


def test_on_soft_floor_too(nao: World) -> None:
    slip = item("slip", "left", dx_m=0.004, time_s=_START, run=1)
    soft = item("soft_ground", "left", compliance_rad_per_nm=0.002)
    sim = nao.standing(changed(DEFAULT, slip, soft))
    assert len(tip_geoms(sim.physics.model, 0)) == len(nao.robot.feet[0].outline)
    before = soles(sim)[0]
    run(sim, standing_still(sim, 1.5), 50.0)
    assert in_sole(before, soles(sim)[0])[0] == pytest.approx(0.004, abs=4e-4)


def test_it_is_not_there_before_it_slips(nao: World) -> None:
    slip = Slip(("left",), (0.005, 0.0, 0.0), 5.0, 1)
    one, other = (nao.standing(rules) for rules in (PERFECT, changed(PERFECT, slip)))
    assert one.snapshot().felt == pytest.approx(other.snapshot().felt, abs=1e-9)


def test_items_that_say_it_wrong() -> None:
    with pytest.raises(FileError, match="run: must be at least 1"):
        item("slip", "left", dx_m=0.005, time_s=1.0, run=0)
    with pytest.raises(FileError, match="time_s: is missing"):
        item("slip", "left", dx_m=0.005, run=1)
