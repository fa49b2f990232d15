"""The run that separates what is confused."""

from __future__ import annotations

from itertools import combinations

import pytest

from shoecal_core.diagnosis.next_motion import SEPARATED_BY, UNLOADED, propose
from shoecal_core.diagnosis.possible_motions import BY_HAND, STANCES, YAWED
from shoecal_core.diagnosis.result import NamedHypothesis
from shoecal_core.error_sources.effects.contact import TURNED
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.planning.motion_catalogue import MOTION_KINDS


def hypothesis(effect: str, *place: str, share: float = 0.5) -> NamedHypothesis:
    return NamedHypothesis(effect, place, share)


def test_every_motion_can_be_run_and_every_effect_is_known() -> None:
    known = {*MOTION_KINDS, *STANCES, *BY_HAND, UNLOADED}
    effects = {one.identifier for one in EFFECTS}
    for these, those, motion in SEPARATED_BY:
        assert motion in known
        assert these | those <= effects


@pytest.mark.parametrize(
    ("pair", "motion"),
    [
        (("latency", "low_pass"), "faster"),
        (("floor_tilt", "link_com"), TURNED),
        (("zero_drift", "span_drift"), "unload_right"),
        (("foot_placement", "soft_ground"), YAWED),
    ],
)
def test_near_twins_have_their_motion(pair: tuple[str, str], motion: str) -> None:
    for one, other in (pair, pair[::-1]):
        found = propose((hypothesis(one, "right"), hypothesis(other, "right")))
        assert found is not None
        assert found.motion == motion
        assert set(found.separates) == {f"{one} (right)", f"{other} (right)"}


def test_the_motion_separates_most_of_what_is_probable() -> None:
    lag = hypothesis("latency", "left", share=0.5), hypothesis("low_pass", "left", share=0.4)
    rare = hypothesis("creep", "left", share=0.1)
    found = propose((*lag, rare))
    assert found is not None
    assert found.motion == "faster"
    assert set(found.separates) == {one.label for one in (*lag, rare)}


def test_nothing_is_proposed_where_nothing_helps() -> None:
    assert propose(()) is None
    assert propose((hypothesis("latency", "left"),)) is None
    # Exact twins, and one effect at two places.
    places = hypothesis("crosstalk", "left/rear_left", "left/front_left"), "left/front_left"
    assert propose((places[0], hypothesis("cell_position", places[1]))) is None
    assert propose((hypothesis("slip", "left"), hypothesis("slip", "right"))) is None


def test_any_two_effects_are_told_by_one_motion_at_most() -> None:
    for one, other in combinations(EFFECTS, 2):
        there = propose((hypothesis(one.identifier, "left"), hypothesis(other.identifier, "left")))
        back = propose((hypothesis(other.identifier, "left"), hypothesis(one.identifier, "left")))
        assert (there and there.motion) == (back and back.motion)
