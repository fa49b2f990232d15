from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.simulation.effects.chains import NAO, PERIOD, item, shoes_with, through
from shoecal_core.simulation.sensor_chain import SensorChain

EFFECTS = (
    item("nonlinearity", "left/front_left", quadratic_per_n=0.003, cubic_per_n2=1e-4),
    item("saturation", "left/rear_left", level_n=8.0),
    item("hysteresis", "left", fraction=0.05),
    item("creep", "all", fraction=0.05, time_s=2.0),
    item("zero_drift", "all", rate_n_per_s=0.01),
    item("span_drift", "right", rate_per_s=0.001),
    item("stuck_cell", "right/rear_right", share=0.5, time_s=0.5),
    item("swapped_cells", "left/front_left", "left/rear_right"),
    item("crosstalk", "right/front_left", "left/front_left", fraction=0.1),
    item("off_axis_load", "all", x=0.1, y=0.05),
    item("latency", "left", delay_s=0.033),
    item("low_pass", "all", time_s=0.05),
)
MIXTURES = st.lists(st.sampled_from(EFFECTS), min_size=1, max_size=6, unique_by=id)
TIMES = np.arange(0.0, 1.0, PERIOD)
FORCES = 6.0 + 5.0 * np.sin(4.0 * TIMES[:, None] + np.arange(8.0))
SIDEWAYS = np.array([[1.0, -0.5], [-1.0, 0.5]])


@settings(max_examples=10)
@given(MIXTURES)
def test_looking_changes_nothing(effects: list[object]) -> None:
    shoes = shoes_with(*(effect for effect in EFFECTS if effect in effects))
    plain = through(shoes, FORCES, sideways=SIDEWAYS)
    chain = SensorChain(shoes)
    for felt, time, expected in zip(FORCES, TIMES, plain, strict=True):
        for ahead in (0.0005, 0.004):
            chain.at(2.0 * felt, time + ahead - PERIOD, SIDEWAYS)
        chain.take(felt, time, SIDEWAYS)
        assert (chain.latest() == expected).all()


@settings(max_examples=10)
@given(MIXTURES)
def test_the_order_of_a_file_is_not_the_order_of_the_physics(effects: list[object]) -> None:
    chosen = [effect for effect in EFFECTS if effect in effects]
    one, other = (
        through(shoes_with(*order), FORCES, sideways=SIDEWAYS) for order in (chosen, chosen[::-1])
    )
    assert one == pytest.approx(other, abs=1e-12)


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: type(effect).__name__)
def test_each_effect_shows(effect: object) -> None:
    shoes = shoes_with(*(one for one in EFFECTS if one is effect))
    reached = through(shoes, FORCES, sideways=SIDEWAYS)
    assert np.abs(reached - FORCES).max() > 0.01
    assert np.isfinite(reached).all()


def test_a_look_between_two_instants_lies_between_them() -> None:
    chain = SensorChain(shoes_with(item("low_pass", "all", time_s=0.05)))
    for felt, time in zip(FORCES, TIMES, strict=True):
        chain.take(felt, time)
    after = FORCES[-1] + 1.0
    ways = [chain.at(FORCES[-1] + part, TIMES[-1] + part * PERIOD) for part in (0.0, 0.3, 0.7, 1.0)]
    chain.take(after, TIMES[-1] + PERIOD)
    assert ways[-1] == pytest.approx(chain.at(after, TIMES[-1] + PERIOD))
    for less, more in itertools.pairwise(ways):
        assert np.abs(more - less).max() < 0.1


def test_a_lifted_foot_forgets_its_loops_and_late_readings_not_its_creep() -> None:
    chain = SensorChain(shoes_with(*EFFECTS[2:4], EFFECTS[10]))
    for felt, time in zip(FORCES, TIMES, strict=True):
        chain.take(felt, time)
    chain.lift()
    empty = chain.at(np.zeros(8), TIMES[-1])
    crept = SensorChain(shoes_with(EFFECTS[3]))
    for felt, time in zip(FORCES, TIMES, strict=True):
        crept.take(felt, time)
    crept.lift()
    assert (empty[4:] == crept.at(np.zeros(8), TIMES[-1])[4:]).all()
    assert empty[4:].max() > 0.05


def test_shoes_without_effects_pass_everything_as_it_is() -> None:
    chain = SensorChain(shoes_with())
    assert not chain.active
    assert (chain.at(FORCES[3], 1.0) == FORCES[3]).all()
    assert len(NAO.channels) == FORCES.shape[1]


def test_in_the_middle_of_a_session_nothing_has_crept_but_much_has_drifted() -> None:
    creep, drift = item("creep", "all", fraction=0.1, time_s=1.0), EFFECTS[4]
    chain = SensorChain(shoes_with(creep, drift), 300.0)
    chain.take(FORCES[0], 300.0)
    assert chain.latest() == pytest.approx(FORCES[0] + 300.0 * 0.01)
