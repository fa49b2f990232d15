from __future__ import annotations

import numpy as np
import pytest

from core.simulation.effects.chains import item
from core.simulation.worlds import DEFAULT, PERFECT, World, changed, load_world
from shoecal_core.errors import NameNotFoundError, ShoecalError
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe import wrench
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.rig import LoadingRig
from shoecal_core.simulation.sampled_robot import draw_shoes

MASSES = (1.0, 2.5, 4.0)


def holes(world: World, foot: int) -> list[tuple[float, float]]:
    polygon = world.robot.feet[foot].sensing_polygon
    (left, low), (right, high) = polygon.min(axis=0), polygon.max(axis=0)
    return [(x, y) for x in np.linspace(left, right, 6) for y in np.linspace(low, high, 3)]


def errors(world: World, rules: PlantVariation, foot: int, seed: int) -> tuple[float, float]:
    """MAE of GRF [N] and CoP [m] with every cell's gain and zero known."""
    shoe = world.shoe
    drawn = draw_shoes(rules, shoe, seed)
    rig = LoadingRig(shoe, rules, drawn, np.random.default_rng(seed))
    bare = rig.readings(0.0, foot, np.zeros(2), count=20).voltages.mean(axis=0)
    grf, cop = [], []
    channels = shoe.of_foot(foot)
    for mass in MASSES:
        for hole in holes(world, foot):
            volts = rig.readings(mass, foot, np.array(hole), count=5).voltages.mean(axis=0)
            forces = drawn.parameters.gain * (volts - bare)
            found = forces[channels] @ shoe.columns[channels]
            grf.append(abs(found[0] - mass * GRAVITY))
            cop.append(np.linalg.norm(wrench.cop(found, 0.5) - hole))
    return float(np.mean(grf)), float(np.mean(cop))


@pytest.mark.parametrize("foot", [0, 1])
def test_a_perfect_shoe_weighs_right(world: World, foot: int) -> None:
    grf, cop = errors(world, PERFECT, foot, 1)
    assert grf < 1e-3
    assert cop < 5e-5


def test_a_real_shoe_weighs_well_but_places_badly(nao: World) -> None:
    by_foot = np.array(
        [[errors(nao, DEFAULT, foot, seed) for foot in (0, 1)] for seed in (1, 2, 3)]
    )
    assert by_foot[..., 0].max() < 0.03
    left, right = by_foot[..., 1].mean(axis=0)
    assert 3e-3 < right < left < 5e-3


def test_the_other_foot_feels_nothing(nao: World) -> None:
    drawn = draw_shoes(DEFAULT, nao.shoe, 1)
    rig = LoadingRig(nao.shoe, DEFAULT, drawn, np.random.default_rng(1))
    readings = rig.readings(2.0, 0, np.array([0.02, 0.0]), count=50)
    outputs = drawn.parameters.outputs(readings.voltages).mean(axis=0)
    assert outputs[nao.shoe.of_foot(1)] == pytest.approx(np.zeros(4), abs=0.01)


def test_a_cell_alone_carries_the_whole_weight(nao: World) -> None:
    drawn = draw_shoes(DEFAULT, nao.shoe, 1)
    rig = LoadingRig(nao.shoe, DEFAULT, drawn, np.random.default_rng(1))
    name, index = nao.shoe.names[3], 3
    rise = (
        rig.cell_readings(1.0, name, count=50).voltages
        - rig.cell_readings(0.0, name, count=50).voltages
    ).mean(axis=0)
    assert drawn.parameters.gain[index] * rise[index] == pytest.approx(GRAVITY, abs=0.01)
    with pytest.raises(NameNotFoundError):
        rig.cell_readings(1.0, "left/nose")


def test_a_weight_beside_the_shoe_tips_it(nao: World) -> None:
    rig = LoadingRig(nao.shoe, DEFAULT, draw_shoes(DEFAULT, nao.shoe, 1), np.random.default_rng(1))
    with pytest.raises(ShoecalError, match="left shoe does not stand still under 4 kg"):
        rig.readings(4.0, 0, np.array([0.3, 0.0]))
    with pytest.raises(ShoecalError, match=r"a weight of -1 kg"):
        rig.readings(-1.0, 0, np.zeros(2))


def test_the_same_generator_gives_the_same_readings() -> None:
    odd = load_world("odd_biped")
    drawn = draw_shoes(DEFAULT, odd.shoe, 1)
    once, again = (
        LoadingRig(odd.shoe, DEFAULT, drawn, np.random.default_rng(3)).readings(
            3.0, 1, np.array([0.02, 0.01]), count=4
        )
        for _ in range(2)
    )
    assert (once.counts == again.counts).all()


def test_effects_act_on_the_bench_too(nao: World) -> None:
    listed = (
        item("saturation", nao.shoe.names[0], level_n=6.0),
        item("creep", nao.shoe.names[1], fraction=0.1, time_s=0.5),
        item("low_pass", "all", time_s=0.2),
    )
    rules = changed(PERFECT, *listed)
    drawn = draw_shoes(rules, nao.shoe, 1)
    rig = LoadingRig(nao.shoe, rules, drawn, np.random.default_rng(1))
    for channel, expected in zip(nao.shoe.names, (6.0, 1.1 * GRAVITY, GRAVITY), strict=False):
        readings = rig.cell_readings(1.0, channel, count=2)
        outputs = drawn.parameters.outputs(readings.voltages)
        assert outputs[:, nao.shoe.index(channel)] == pytest.approx(expected, rel=0.01)
