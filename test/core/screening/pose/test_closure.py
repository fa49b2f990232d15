"""Feet that slip or leave the floor, as the joints tell it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import Recording, recording, turned
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.lifting import lifted
from shoecal_core.screening.pose.closure import Slipped, feet, slips


def stepped(
    whole: Recording, run: int, second: float, shift: tuple[float, float, float], load: float
) -> Recording:
    """From a second on the right foot is elsewhere (m, m, rad), and the load is shared anew (N)."""
    one = whole.aligned[run]
    after = one.time >= second
    states = one.states
    moved = states.translation + np.where(after[:, None], [*shift[:2], 0.0], 0.0)
    rotation = turned(states.yaw + np.where(after, shift[2], 0.0))
    pattern = load * np.array([1.0, -1.0, -0.5, 0.5, -1.0, 1.0, 0.5, -0.5])
    readings = one.readings + np.where(after[:, None], pattern / whole.parameters.gain, 0.0)
    states = replace(states, translation=moved, rotation=rotation)
    return whole.with_run(run, states=states, readings=readings)


def found_in(runs: Mapping[int, Aligned]) -> dict[int, Slipped]:
    everything = {
        run: feet(one, one.readings, np.ones(len(one.time), dtype=bool))
        for run, one in runs.items()
    }
    return slips(everything)


def test_feet_that_stay() -> None:
    for count in (2, 3, 5):
        whole = recording(count, count=count)
        assert found_in(whole.aligned) == {}
        assert not any(lifted(one.states).any() for one in whole.aligned.values())


@pytest.mark.parametrize(
    "shift", [(0.003, 0.0, 0.0), (0.0, -0.002, 0.004), (0.0, 0.0, 0.02), (-0.001, 0.001, 0.01)]
)
def test_a_step_that_stays_is_a_slip(shift: tuple[float, float, float]) -> None:
    found = found_in(stepped(recording(), 2, 14.0, shift, 1.0).aligned)
    assert set(found) == {2}
    assert found[2].time == pytest.approx(14.0, abs=0.3)
    np.testing.assert_allclose(found[2].shift, shift, atol=1e-3)


def test_a_step_within_what_the_fit_allows_is_none() -> None:
    """Play of the gears makes such steps where a joint's load changes its side."""
    assert found_in(stepped(recording(), 2, 14.0, (-0.0004, 0.0002, -0.0035), 1.0).aligned) == {}


def test_the_first_of_two_slips_is_told() -> None:
    whole = stepped(recording(), 1, 9.0, (0.003, 0.0, 0.0), 1.0)
    whole = stepped(whole, 1, 20.0, (0.006, 0.0, 0.0), 1.0)
    assert found_in(whole.aligned)[1].time == pytest.approx(9.0, abs=0.3)


def test_wandering_without_a_step_of_the_load_is_none() -> None:
    """Play and compliance let the joints wander as the body sways."""
    whole = recording()
    one = whole.aligned[3]
    wander = 0.0015 * np.sin(2.0 * np.pi * one.time / 11.0)[:, None] * [1.0, 0.5, 0.0]
    states = replace(one.states, translation=one.states.translation + wander)
    assert found_in(whole.with_run(3, states=states).aligned) == {}


def test_a_load_that_steps_without_the_feet_is_none() -> None:
    assert found_in(stepped(recording(), 2, 14.0, (0.0, 0.0, 0.0), 2.0).aligned) == {}


def test_too_short_a_run_tells_nothing() -> None:
    one = recording().aligned[1]
    few = one.part(one.time < 0.3)
    assert found_in({1: few}) == {}
    assert found_in({1: one.part(one.time < 0.0)}) == {}


@pytest.mark.parametrize("tilt", [False, True])
def test_a_foot_off_the_floor(tilt: bool) -> None:
    one = recording().aligned[1]
    up = (one.time > 10.0) & (one.time < 11.0)
    states = one.states
    if tilt:
        c, s = np.cos(0.05), np.sin(0.05)
        edge = states.rotation @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        rotation = np.where(up[:, None, None], edge, states.rotation)
        states = replace(states, rotation=rotation)
    else:
        high = np.where(up, 0.006, 0.0)[:, None] * [0.0, 0.0, 1.0]
        states = replace(states, translation=states.translation + high)
    np.testing.assert_array_equal(lifted(states), up)
