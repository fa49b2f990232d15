"""Motions that a diagnosis proposes: what the robot does for them, and what a person has to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from shoecal_core.diagnosis.possible_motions import (
    BY_HAND,
    STANCE_MOTION,
    STANCES,
    WARM,
)
from shoecal_core.error_sources.effects.contact import TURNED
from shoecal_core.errors import NameNotFoundError
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.samples.known_weight import WEIGHTED


@dataclass(frozen=True)
class Proposal:
    """What a name means.

    Attributes:
        motion: on the planner's catalogue.
        stance: one of STANCES, where it is done; empty: in the session's own double supports.
        by_hand: what a person does before; empty: the robot can do it all.
    """

    motion: str
    stance: str = ""
    by_hand: str = ""


_BY_HAND = {
    TURNED: "turn the robot by 180 degrees, on the same place of the same floor",
    WARM: "leave it standing with its motors on for {minutes:g} minutes",
    WEIGHTED: "fasten {mass:g} kg to the torso, at the origin of its frame",
}
BEYOND_MENU: Mapping[str, Proposal] = {
    **{name: Proposal(STANCE_MOTION, stance=name) for name in STANCES},
    **{
        name: Proposal(
            hand.motion,
            by_hand=_BY_HAND[name].format(minutes=hand.later / 60.0, mass=hand.mass),
        )
        for name, hand in BY_HAND.items()
    },
}
"""What a diagnosis may propose in addition to the motions of the catalogue."""


def proposal(name: str) -> Proposal:
    """What a motion of the catalogue, or one beyond it, means.

    Raises:
        NameNotFoundError: for another one.
    """
    if name in MOTION_KINDS:
        return Proposal(name)
    if name not in BEYOND_MENU:
        raise NameNotFoundError("motion", name, (*MOTION_KINDS, *BEYOND_MENU))
    return BEYOND_MENU[name]


def planned_as(name: str) -> str:
    """What to ask the planner for; names it does not know either are left to it."""
    return BEYOND_MENU[name].motion if name in BEYOND_MENU else name


def by_hand(name: str) -> str:
    """What a person has to do before a proposed motion; empty: nothing."""
    return proposal(name).by_hand


def how_to_go_on(name: str, session: Path) -> str:
    """The goal of `shoe/diagnose` that runs a proposed motion, and what a person does before."""
    before = by_hand(name)
    first = f"{before}, then " if before else ""
    return f"next {name}: {first}send the goal {{session: '{session.name}', motions: [{name}]}}"
