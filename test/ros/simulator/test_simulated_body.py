from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.bodies import ROOT, nao, nao_shoe
from shoecal_core.planning.posture import stance
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw
from shoecal_ros.simulator.simulated_body import START_NS, Pacer, SimulatedBody


def body() -> SimulatedBody:
    reality = load_reality(ROOT / "config/realities/default.yaml")
    drawn = draw(reality, nao(), nao_shoe(), 1)
    return SimulatedBody(SimulatedRobot(nao(), nao_shoe(), drawn, np.random.default_rng(1)), 100.0)


def test_stamps_increase_evenly_over_batches_and_placements() -> None:
    simulated = body()
    stamps = [*simulated.advance(7).stamp_ns, *simulated.advance(1).stamp_ns]
    expected = simulated.after(5)
    stamps += [*simulated.advance(5).stamp_ns]
    assert stamps[-1] == expected == simulated.now_ns
    legs = stance(nao(), DoubleSupport(0.02, -0.11, 0.1))
    simulated.place(nao().from_legs(legs))
    assert simulated.now_ns == expected
    assert simulated.since_placed == 0.0
    stamps += [*simulated.advance(3).stamp_ns]
    assert set(np.diff(stamps)) == {10_000_000}
    assert stamps[0] == START_NS + 10_000_000


def test_a_placed_robot_comes_to_rest() -> None:
    simulated = body()
    simulated.place(nao().from_legs(stance(nao(), DoubleSupport(0.0, -0.12, 0.2))))
    simulated.advance(2)
    assert simulated.rested < 1.0
    while simulated.rested < 1.0:
        assert simulated.since_placed < 5.0
        samples = simulated.advance(5)
    assert samples.truth.grf[-1] == pytest.approx(simulated.robot.weight, rel=1e-3)
    assert samples.readings.counts.shape == (5, 8)


@given(st.floats(0.5, 10.0), st.lists(st.floats(0.0, 0.1), min_size=1, max_size=100))
def test_the_pace_is_kept(speed: float, waits: list[float]) -> None:
    pacer = Pacer(speed, 100.0, 1000, 50.0)
    now, given = 50.0, 0
    for wait in waits:
        now += wait
        given += pacer.due(now)
        assert given == pytest.approx((now - 50.0) * speed * 100.0, abs=1.0)


def test_time_lost_is_not_made_up_for() -> None:
    pacer = Pacer(1.0, 100.0, 20, 0.0)
    assert pacer.due(10.0) == 20
    assert pacer.due(10.0) == 1
    assert pacer.due(10.1) == pytest.approx(10, abs=1)
