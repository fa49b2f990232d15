from __future__ import annotations

import numpy as np
import pytest

from core.simulation.effects.chains import NAO, SIX_AXIS, item, shoes_with
from core.simulation.test_disturbances import standing_still
from core.simulation.worlds import PERFECT, World, changed
from shoecal_core.errors import FileError
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.samples import run
from shoecal_core.simulation.sensor_chain import SensorChain

OFFSET = 2.0


def zero(*location: str, number: int = 2) -> Effect:
    """Off by OFFSET in one run."""
    return item("zero_offset", *location, offset_n=OFFSET, run=number)


@pytest.mark.parametrize(
    ("place", "channels"),
    [("left/rear_left", [2]), ("right", [4, 5, 6, 7]), ("all", list(range(8)))],
)
def test_readings_of_one_run_are_higher_by_the_offset(
    nao: World, place: str, channels: list[int]
) -> None:
    """From the run's first reading to its last, by the true gains."""
    plain, off = nao.standing(PERFECT), nao.standing(changed(PERFECT, zero(place)))
    expected = np.zeros(8)
    expected[channels] = OFFSET
    gain = off.drawn.shoes.parameters.gain
    for number in (1, 2, 3):
        if number > 1:
            for sim in (plain, off):
                sim.place(nao.robot.posture)
        one, other = (
            run(sim, standing_still(sim, 0.2), 50.0, hold=0.1).readings.voltages
            for sim in (plain, off)
        )
        higher = (other - one) * gain
        np.testing.assert_allclose(
            higher, np.broadcast_to(expected * (number == 2), higher.shape), atol=1e-4
        )


@pytest.mark.parametrize(
    ("shoe", "place", "channels"),
    [
        (NAO, "left", ["left/front_left", "left/front_right", "left/rear_left", "left/rear_right"]),
        (SIX_AXIS, "all", ["left/fz", "right/fz"]),
        (SIX_AXIS, "left/fx", ["left/fx"]),
    ],
)
def test_a_foot_s_offset_is_that_of_each_vertical_force(
    shoe: Shoe, place: str, channels: list[str]
) -> None:
    chain = SensorChain(shoes_with(zero(place), shoe=shoe))
    felt = np.ones(len(shoe.names))
    for number in range(4):
        chain.run = number
        chain.take(felt, float(number))
        higher = chain.latest() - felt
        shown = [name for name, more in zip(shoe.names, higher, strict=True) if more]
        assert shown == (channels if number == 2 else [])
        assert set(higher) <= {0.0, OFFSET}


def test_runs_may_each_have_their_own() -> None:
    chain = SensorChain(shoes_with(zero("left", number=1), zero("all", number=3)))
    found = []
    for number in (1, 2, 3):
        chain.run = number
        chain.take(np.zeros(8), float(number))
        found.append(chain.latest())
    wanted = np.zeros((3, 8))
    wanted[0, :4], wanted[2] = OFFSET, OFFSET
    np.testing.assert_array_equal(found, wanted)


@pytest.mark.parametrize(
    ("location", "sizes", "message"),
    [
        ("left", {"offset_n": 1.0}, "run: is missing"),
        ("left", {"offset_n": 1.0, "run": 0}, "run: must be at least 1"),
        ("left", {"run": 1}, "offset_n: is missing"),
    ],
)
def test_items_that_say_it_wrong(location: str, sizes: dict[str, float], message: str) -> None:
    with pytest.raises(FileError, match=message):
        item("zero_offset", location, **sizes)


def test_a_torque_has_no_newtons() -> None:
    with pytest.raises(FileError, match="reads a torque"):
        shoes_with(zero("left/mx"), shoe=SIX_AXIS)
