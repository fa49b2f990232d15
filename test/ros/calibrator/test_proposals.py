from __future__ import annotations

from pathlib import Path

import pytest

from shoecal_core.errors import NameNotFoundError
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_ros.calibrator.proposals import (
    BEYOND_MENU,
    by_hand,
    how_to_go_on,
    planned_as,
    proposal,
)


@pytest.mark.parametrize("name", [*MOTION_KINDS, *BEYOND_MENU])
def test_whatever_is_proposed_ends_in_a_motion_of_the_menu(name: str) -> None:
    assert planned_as(name) == proposal(name).motion
    assert planned_as(name) in MOTION_KINDS


def test_motions_of_the_menu_need_nobody() -> None:
    assert not any(by_hand(name) for name in MOTION_KINDS)
    assert not by_hand("yawed_stance")
    assert "for 10 minutes" in by_hand("warm_up")
    assert "fasten 0.5 kg" in by_hand("known_weight")


def test_how_to_go_on_is_a_goal_and_what_comes_before_it() -> None:
    reported = how_to_go_on("unload_left", Path("/data/s1"))
    assert reported == "next unload_left: send the goal {session: 's1', motions: [unload_left]}"
    reported = how_to_go_on("turn_180", Path("/data/s1"))
    assert "turn the robot by 180 degrees" in reported
    assert reported.endswith("then send the goal {session: 's1', motions: [turn_180]}")


def test_unknown_names_are_told_with_those_that_are_known() -> None:
    with pytest.raises(NameNotFoundError, match=r"somersault.*landmarks.*yawed_stance"):
        proposal("somersault")
