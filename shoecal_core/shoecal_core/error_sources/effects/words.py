"""What each effect does, and what to do about it, in words for a person."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Words:
    """Words for one effect.

    Attributes:
        state: what it does at its place, after the place's name.
        cure: what to do, with `{place}` where that matters.
    """

    state: str
    cure: str


WORDS: Mapping[str, Words] = {
    "nonlinearity": Words(
        "bends with load",
        "exchange the cell {place}, or keep it to loads at which it is straight",
    ),
    "saturation": Words(
        "saturates",
        "give the cell {place} a larger range, or its amplifier a smaller gain",
    ),
    "hysteresis": Words(
        "has hysteresis",
        "check {place} for friction in its mounting, then exchange the cell",
    ),
    "creep": Words(
        "creeps under load",
        "wait under load before recording; if {place} creeps on, exchange the cell",
    ),
    "zero_offset": Words(
        "has a shifted zero",
        "correct the zeros of {place} from feet in the air: --rezero",
    ),
    "zero_drift": Words(
        "has a drifting zero",
        "warm up {place} before recording, then correct the zeros: --rezero",
    ),
    "span_drift": Words(
        "has a drifting gain",
        "warm up {place} before recording, and calibrate at that temperature",
    ),
    "stuck_cell": Words(
        "is stuck",
        "check cable and amplifier of {place}, then exchange the cell",
    ),
    "swapped_cells": Words(
        "has its cable at the other's place",
        "exchange the cables of {place}, or their channels in the shoe file",
    ),
    "crosstalk": Words(
        "shows the other's load",
        "check ground and supply of {place}, and where the second one is mounted",
    ),
    "cell_position": Words(
        "is not where the shoe file says",
        "measure where {place} is mounted, and correct its position in the shoe file",
    ),
    "off_axis_load": Words(
        "feels sideways forces",
        "decouple the cells of {place} from sideways forces",
    ),
    "latency": Words(
        "reads late",
        "correct the stamps of {place} by the delay found",
    ),
    "low_pass": Words(
        "lags behind a filter",
        "shorten the filter of {place}, in the amplifier or the driver",
    ),
    "total_mass": Words(
        "weighs other than its file says",
        "weigh the robot, and pass its weight: --weight-kg",
    ),
    "payload": Words(
        "carries a mass that the model does not know",
        "take the mass off {place}, or enter it in the robot's URDF",
    ),
    "link_com": Words(
        "has its centre of mass elsewhere than in the URDF",
        "correct the centre of mass of {place} in the robot's URDF",
    ),
    "joint_offset": Words(
        "has an encoder offset",
        "set the encoder zero of {place}",
    ),
    "joint_compliance": Words(
        "gives under load",
        "check gears and mounting of {place}",
    ),
    "backlash": Words(
        "has backlash",
        "check the play in the gears of {place}",
    ),
    "foot_placement": Words(
        "is mounted elsewhere than modelled",
        "check how the shoe of {place} sits, or correct its sole in the robot file",
    ),
    "slip": Words(
        "slipped",
        "repeat the run in which {place} slipped, on a floor with more grip",
    ),
    "floor_tilt": Words(
        "is on a floor that is not level",
        "level the floor, or record elsewhere",
    ),
    "soft_ground": Words(
        "is on soft ground",
        "record on a hard floor",
    ),
    "inertia": Words(
        "moves too fast to be taken as standing still",
        "record slower motions",
    ),
}
"""By effect; those of a user's own have none."""


def name_of(effect: str) -> str:
    """An effect's identifier as a name."""
    return effect.replace("_", " ")


def words_of(effect: str) -> Words:
    """Of any effect, a user's own too."""
    name = name_of(effect)
    return WORDS.get(effect, Words(f"shows {name}", f"look into {name} at {{place}}"))
