"""The effects of docs/reference/effects.md, as the generator and the scorer know them.

Written from the table, not from the diagnosis' code: identifiers, classes, the kinds of places an
effect can have, components with their units, and what looks exactly alike.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from blind.answers import Place

SUFFIX: Mapping[str, str] = {
    "s": "_s", "m": "_m", "rad": "_rad", "kg": "_kg", "N": "_n", "": "", "1/N": "_per_n",
    "1/N^2": "_per_n2", "N/s": "_n_per_s", "1/s": "_per_s", "rad/(N m)": "_rad_per_nm",
}  # fmt: skip
"""Ends the key of a size in a reality file, by unit."""


@dataclass(frozen=True)
class EffectKind:
    """One row of the table.

    Attributes:
        group: its class.
        places: kinds of places: cell, foot, all, pair (receiver and donor), swap (two cells),
            joint, legs (`all` joints), link, none.
        units: by component.
    """

    group: str
    places: tuple[str, ...]
    units: Mapping[str, str]


_RATE = ("cell", "foot", "all")
_FEET = ("foot", "all")

EFFECTS: Mapping[str, EffectKind] = {
    "nonlinearity": EffectKind("load_cell", ("cell",), {"quadratic": "1/N", "cubic": "1/N^2"}),
    "saturation": EffectKind("load_cell", ("cell",), {"level": "N"}),
    "hysteresis": EffectKind("load_cell", ("cell", "foot"), {"fraction": ""}),
    "creep": EffectKind("load_cell", ("cell", "foot"), {"fraction": "", "time": "s"}),
    "zero_drift": EffectKind("load_cell", _RATE, {"rate": "N/s"}),
    "span_drift": EffectKind("load_cell", _RATE, {"rate": "1/s"}),
    "stuck_cell": EffectKind("load_cell", ("cell",), {"share": "", "time": "s"}),
    "swapped_cells": EffectKind("load_cell", ("swap",), {}),
    "crosstalk": EffectKind("load_cell", ("pair",), {"fraction": ""}),
    "cell_position": EffectKind("load_cell", ("cell",), {"x": "m", "y": "m"}),
    "off_axis_load": EffectKind("load_cell", ("foot",), {"x": "", "y": ""}),
    "latency": EffectKind("timing", _FEET, {"delay": "s"}),
    "low_pass": EffectKind("timing", _FEET, {"time": "s"}),
    "payload": EffectKind("body", ("link",), {"mass": "kg"}),
    "link_com": EffectKind("body", ("link",), {"x": "m", "y": "m", "z": "m"}),
    "joint_offset": EffectKind("body", ("joint",), {"angle": "rad"}),
    "joint_compliance": EffectKind("body", ("joint", "legs"), {"compliance": "rad/(N m)"}),
    "backlash": EffectKind("body", ("joint", "legs"), {"play": "rad"}),
    "foot_placement": EffectKind("contact", ("foot",), {"dx": "m", "dy": "m", "dtheta": "rad"}),
    "slip": EffectKind(
        "contact", ("foot",), {"dx": "m", "dy": "m", "dtheta": "rad", "time": "s"}
    ),
    "floor_tilt": EffectKind("contact", ("none",), {"about_x": "rad", "about_y": "rad"}),
    "soft_ground": EffectKind("contact", _FEET, {"compliance": "rad/(N m)"}),
    "inertia": EffectKind("dynamics", ("none",), {"factor": ""}),
}  # fmt: skip
"""By identifier."""

NEAR_TWINS: tuple[frozenset[str], ...] = (
    frozenset(("foot_placement", "soft_ground")),
    frozenset(("floor_tilt", "joint_offset")),
    frozenset(("latency", "low_pass")),
    frozenset(("foot_placement", "cell_position")),
    frozenset(("zero_drift", "span_drift")),
    frozenset(("link_com", "payload")),
    frozenset(("creep", "hysteresis")),
)
"""Effects that are hard to tell apart; the confusion matrix names them."""

_SAME = {"RHipYawPitch": "LHipYawPitch", "base_link": "base"}
"""Names of the NAO for one thing: joints that one motor drives, the root link."""


def exactly(place: Place) -> Place:
    """One name for all that nothing in any recording could tell from a place.

    A cell that hears its neighbour (`crosstalk`) pulls the neighbour's place along the line
    between them; feet that move against each other do not tell which of them moved.
    """
    effect, location = place.effect, place.location
    if effect == "crosstalk":
        return Place("cell_position", location[1:])
    if effect == "slip":
        return Place("slip", ("left",))
    if effect == "swapped_cells":
        return Place(effect, tuple(sorted(location)))
    return Place(effect, named_once(location))


def named_once(location: tuple[str, ...]) -> tuple[str, ...]:
    """Every name as the one that stands for the same thing."""
    return tuple(_SAME.get(name, name) for name in location)


def alike(effect: str) -> str:
    """One name for effects that are exact twins."""
    return "cell_position" if effect == "crosstalk" else effect


def item(effect: str, location: tuple[str, ...], size: Mapping[str, float]) -> dict[str, object]:
    """An effect as a reality file lists it."""
    units = EFFECTS[effect].units
    told: dict[str, object] = {"effect": effect}
    if location:
        told["location"] = list(location)
    return told | {name + SUFFIX[units[name]]: value for name, value in size.items()}
