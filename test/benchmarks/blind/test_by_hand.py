"""A robot after what a person did is the same robot elsewhere, later, or heavier."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from blind.by_hand import BY_HAND, ByHand, after
from core.simulation.worlds import PERFECT, load_world
from shoecal_core.diagnosis import candidates
from shoecal_core.model.robot import GRAVITY
from shoecal_core.simulation.effects.contact import FloorTilt
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.shoe_physics import floor_rotation

SLOPE = dataclasses.replace(PERFECT, effects=(FloorTilt(0.03, -0.02),))


def done(what: ByHand) -> tuple[SimulatedRobot, SimulatedRobot]:
    before = load_world("nao").standing(SLOPE)
    before.begin_run()
    return before, after(what, before, np.random.default_rng(2))


def test_it_is_what_the_diagnosis_asks_for() -> None:
    asked = {
        name: (one.motion, one.mass, one.later if one.warmer else 0.0)
        for name, one in candidates.BY_HAND.items()
    }
    assert asked == {name: (one.motion, one.mass, one.wait) for name, one in BY_HAND.items()}


def test_a_turned_robot_sees_the_slope_from_the_other_side() -> None:
    before, turned = done(BY_HAND["turn_180"])
    half = np.diag([-1.0, -1.0, 1.0])
    up, seen = (floor_rotation(one.drawn.shoes).T[:, 2] for one in (before, turned))
    np.testing.assert_allclose(seen, half @ up)
    assert turned.weight == pytest.approx(before.weight)


def test_a_known_weight_adds_itself() -> None:
    before, loaded = done(BY_HAND["known_weight"])
    assert loaded.weight - before.weight == pytest.approx(0.5 * GRAVITY)


def test_runs_and_time_go_on() -> None:
    before, later = done(BY_HAND["warm_up"])
    assert later.session_time - before.session_time == pytest.approx(600.0, abs=1e-6)
    later.begin_run()
    assert later.run == 2
