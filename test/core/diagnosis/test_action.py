"""What a person is told to do about a diagnosis."""

from __future__ import annotations

from dataclasses import replace

import pytest

from core.report.diagnoses import cause, diagnosis
from shoecal_core.diagnosis.action import action
from shoecal_core.diagnosis.result import Where
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.effects.words import words_of

FOUND = replace(diagnosis(), next_motion=None)


@pytest.mark.parametrize("effect", [one.identifier for one in EFFECTS])
def test_there_is_a_cure_for_every_effect(effect: str) -> None:
    """With the place it is at, and in which run it happened."""
    one = cause(effect, "load_cell", ("left/front_left",), 0.9, run=3)
    told = action(replace(FOUND, causes=(one,)))
    assert told.do.endswith("(run 3)")
    assert ("left/front_left" in told.do) == ("{place}" in words_of(effect).cure)
    assert told.expected_cop_mm == one.shrink.cop_mae_mm


def test_zeros_of_several_runs_are_one_thing_to_do() -> None:
    moved = [cause("zero_offset", "load_cell", (foot,), 1.0, run=run) for foot, run in
             (("right", 4), ("left", 1), ("left", 4))]  # fmt: skip
    heavy = cause("total_mass", "body", ("all",), 0.8)
    told = action(replace(FOUND, causes=(*moved, heavy)))
    assert (
        told.do == "correct the zeros of right and left from feet in the air: --rezero (runs 1, 4)"
    )


def test_an_effect_of_a_users_own_is_looked_into() -> None:
    own = cause("loose_plate", "load_cell", ("left",), 0.9)
    assert action(replace(FOUND, causes=(own,))).do == "look into loose plate at left"


def test_what_is_confused_is_told_apart_first() -> None:
    told = action(diagnosis(verdict="ambiguous"))
    assert told.do == (
        "record the motion hold to separate nonlinearity (left/front_left) from hysteresis "
        "(left/front_left)"
    )


def test_without_a_cause_the_place_of_the_gap_is_named() -> None:
    unknown = replace(FOUND, verdict="unknown", causes=())
    most = Where("parity", "right", None, None, 4, None, None, 0.9)
    assert action(unknown).do == "look for what is off in cop_y of the left foot"
    told = action(replace(unknown, where=(*unknown.where, most)))
    assert told.do == "look for what is off in parity of the right foot, mostly in run 4"
    assert told.expected_cop_mm == (unknown.gap.cop_mae_mm, unknown.gap.cop_floor_mm)


def test_nothing_is_to_be_done_about_a_robot_as_built() -> None:
    told = action(replace(FOUND, verdict="no_gap", causes=()))
    assert told.do.startswith("nothing")
    assert told.expected_cop_mm[0] == told.expected_cop_mm[1]
