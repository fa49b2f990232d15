"""Drawing an effect: where it sits, and its size from one magnitude."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

import numpy as np

from blind.gap import MeasuredGap
from blind.layout import UNIT_SIZES
from population import nao
from shoecal_core.shoe.shoe import FEET

Size = dict[str, float]

AIM = 3.0
"""Gap over the floor that guesses are meant to make, and measured sizes come near to."""
STRENGTHS = (1.5, 3.0, 6.0)
"""Gap over the floor that an effect is meant to make alone."""

JOINTS = (
    "LHipYawPitch", "LHipRoll", "LHipPitch", "LKneePitch", "LAnklePitch", "LAnkleRoll",
    "RHipRoll", "RHipPitch", "RKneePitch", "RAnklePitch", "RAnkleRoll",
)  # fmt: skip
LINKS = ("base", "LThigh_link", "RThigh_link", "LTibia_link", "RTibia_link")
CARRIERS = (*LINKS, "Head_link", "LForeArm_link", "RForeArm_link")
"""Links that a payload may hang on."""


def draw_location(effect: str, kind: str, rng: np.random.Generator) -> tuple[str, ...]:
    """A place of a kind."""
    cells = nao()[1].names
    if kind in {"pair", "swap"}:
        foot = FEET[int(rng.integers(2))]
        own = [name for name in cells if name.startswith(foot)]
        return tuple(str(own[i]) for i in rng.permutation(len(own))[:2])
    one_of: Mapping[str, tuple[str, ...]] = {
        "cell": cells,
        "foot": FEET,
        "joint": JOINTS,
        "link": CARRIERS if effect == "payload" else LINKS,
        "all": ("all",),
        "legs": ("all",),
    }
    return (str(rng.choice(one_of[kind])),) if kind in one_of else ()


def _along(*names: str, across: float = 1.0) -> Callable[[float, np.random.Generator], Size]:
    """A vector of any direction; its last component counts `across` as much."""

    def size(magnitude: float, rng: np.random.Generator) -> Size:
        way = rng.standard_normal(len(names))
        way *= magnitude / np.linalg.norm(way)
        way[-1] *= across
        return dict(zip(names, way.tolist(), strict=True))

    return size


def _signed(name: str) -> Callable[[float, np.random.Generator], Size]:
    return lambda magnitude, rng: {name: float(rng.choice([-1.0, 1.0])) * magnitude}


def _plain(name: str) -> Callable[[float, np.random.Generator], Size]:
    return lambda magnitude, _: {name: magnitude}


_SIZES: Mapping[str, Callable[[float, np.random.Generator], Size]] = {
    "swapped_cells": lambda _, __: {},
    "cell_position": _along("x", "y"),
    "off_axis_load": _along("x", "y"),
    "payload": _plain("mass"),
    "link_com": _along("x", "y", "z"),
    "joint_offset": _signed("angle"),
    "joint_compliance": _plain("compliance"),
    "backlash": _plain("play"),
    "foot_placement": _along("dx", "dy", "dtheta", across=5.0),
    "slip": _along("dx", "dy", "dtheta", across=5.0),
    "floor_tilt": _along("about_x", "about_y"),
    "soft_ground": _plain("compliance"),
    "inertia": lambda _, __: {"factor": 1.0},
}
"""Of effects whose laws are the simulator's; those of `laws` are sized on their set."""

LIMITS: Mapping[str, float] = {
    "cell_position": 0.02, "off_axis_load": 1.0, "payload": 0.8, "link_com": 0.05,
    "joint_offset": 0.06, "joint_compliance": 0.03, "backlash": 0.04, "foot_placement": 0.015,
    "slip": 0.006, "floor_tilt": 0.06, "soft_ground": 0.03, "inertia": 3.0,
}  # fmt: skip
"""Largest magnitudes: beyond them nobody needs a diagnosis, or the robot no longer stands."""

UNKNOWN = "unknown "
"""Begins the key of what is not in the table."""

FOREIGN_LIMITS: Mapping[str, float] = {
    "cable": 60.0, "rubbing thigh": 600.0, "swinging load": 0.2, "motor pick-up": 0.5,
    "touching edge": 5.0, "loose plate": 0.01, "steadying hand": 6.0, "pebble": 0.0015,
}  # fmt: skip
"""The same of what is not in the table, in each kind's own unit."""

FOREIGN_GUESS: Mapping[str, float] = {
    "cable": 3.0, "rubbing thigh": 20.0, "swinging load": 0.01, "motor pick-up": 0.05,
    "touching edge": 0.06, "loose plate": 0.002, "steadying hand": 0.2, "pebble": 0.0006,
}  # fmt: skip

FIRST_GUESS: Mapping[str, float] = {
    "cell_position": 0.004, "off_axis_load": 0.1, "payload": 0.2, "link_com": 0.01,
    "joint_offset": 0.02, "joint_compliance": 0.01, "backlash": 0.015, "foot_placement": 0.005,
    "slip": 0.004, "floor_tilt": 0.04, "soft_ground": 0.01, "inertia": 2.0,
}  # fmt: skip
"""Magnitudes at which `unit_sizes` begins."""


def draw_size(effect: str, magnitude: float, rng: np.random.Generator) -> Size:
    """Components of a magnitude."""
    return _SIZES[effect](magnitude, rng)


def unit_key(effect: str, location: tuple[str, ...]) -> str:
    """What one unit size stands for: effect and place, cells and feet as one."""
    place = location[0] if location else ""
    if "/" in place:
        place = "cell"
    elif place in FEET:
        place = "foot"
    elif place[:1] in {"L", "R"}:
        place = place[1:]
    return f"{effect} {place}".strip()


@cache
def unit_sizes(file: Path = UNIT_SIZES) -> Mapping[str, Mapping[str, list[float]]]:
    """Measured magnitudes and the gaps over the floor that they make, by `unit_key`."""
    told: Mapping[str, Mapping[str, list[float]]] = json.loads(file.read_text())["sizes"]
    return told


@cache
def unit_floor(file: Path = UNIT_SIZES) -> MeasuredGap:
    """Errors of a perfect robot, which these gaps are over."""
    return MeasuredGap.told(json.loads(file.read_text())["floor"])


def magnitude_of(key: str, strength: float, limit: float) -> float:
    """The magnitude that makes a gap, read off the measured ones, up to a limit.

    Own gaps add to the floor in squares; an own gap grows about evenly with its magnitude. What
    has not been measured is guessed; whatever is drawn, the gap that it makes is measured later.
    """
    told = unit_sizes().get(key) or {"magnitude": [_guess(key)], "gap": [AIM]}
    magnitude = np.log(np.array(told["magnitude"]))
    own = np.log(np.array([own_gap(gap) for gap in told["gap"]]))
    wanted = np.log(own_gap(strength))
    order = np.argsort(own)
    if wanted >= own.max():
        found = magnitude[own.argmax()] + (wanted - own.max())
    elif wanted <= own.min():
        found = magnitude[own.argmin()] - (own.min() - wanted)
    else:
        found = np.interp(wanted, own[order], magnitude[order])
    return min(limit, float(np.exp(found)))


def _guess(key: str) -> float:
    if key.startswith(UNKNOWN):
        return FOREIGN_GUESS[key.removeprefix(UNKNOWN)]
    return FIRST_GUESS[key.split(maxsplit=1)[0]]


def own_gap(gap: float) -> float:
    """Gap over the floor without the floor's own part."""
    return float(np.sqrt(max(gap**2 - 1.0, 0.02)))
