"""The world of a set: a robot as built or a perfect one, computed by another engine.

Steps, servos, contact and cells are drawn beside the values of any reality file, as no real robot
is computed with them either.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from blind.answers import PERFECT, Answer
from shoecal_core.files import write_yaml
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workspace import config_dir

WHOLE = ""
"""Stands for the keys of a reality file that are in no section."""
BASES: Mapping[str, float] = {PERFECT: 0.25, "default": 0.375, "other_laws": 0.375}
"""Realities that worlds change, and how often each is drawn."""
AS_BUILT_FLOOR = 4.0
"""Of a robot as built over that of a perfect one, about: effects have to stand out from it."""
NOISE_N = 0.01
"""Of a perfect robot's cell, in the middle of the range drawn."""
AS_BUILT_NOISE_N = (0.003, 1.0)
"""Of cells as they are bought, good ones to cheap ones."""


AS_BUILT = {
    "body": ("weight_error_n", "mass_error_std_fraction", "com_error_std_m", "com_error_m"),
    "joints": (
        "encoder_error_std_rad", "eccentricity_std_rad", "play_rad", "compliance_rad_per_nm",
        "static_friction_fraction", "kinetic_friction_fraction",
    ),
    "cells": ("position_error_std_m",),
    "shoes": ("clamp_share",),
}  # fmt: skip
"""Keys of errors that any robot is built with, all scaled alike."""

Sections = dict[str, dict[str, float | str]]


def draw_world(rng: np.random.Generator) -> tuple[str, Sections]:
    """A reality, and what is changed of it: gains, offsets, noise, encoders, and the engine."""
    base = str(rng.choice(list(BASES), p=list(BASES.values())))
    return base, draw_sections(rng, base)


def draw_sections(rng: np.random.Generator, base: str = PERFECT) -> Sections:
    """What is changed of a reality."""

    def between(lowest: float, highest: float) -> float:
        return float(np.exp(rng.uniform(np.log(lowest), np.log(highest))))

    noise = (0.5 * NOISE_N, 2.0 * NOISE_N) if base == PERFECT else AS_BUILT_NOISE_N
    return {
        WHOLE: {"step_s": float(rng.choice([0.002, 0.01 / 3.0]))},
        "engine": {
            "cone": "elliptic",  # loaded feet chatter on pyramids
            "sideways_ratio": between(5.0, 20.0),
        },
        "servo": {
            "full_torque_error_rad": between(0.008, 0.018),
            "damping_time_s": between(0.02, 0.045),
            "rotor_inertia_kgm2_per_nm": between(0.0012, 0.003),
        },
        "floor": {"friction": between(0.7, 1.1), "contact_time_s": between(0.007, 0.012)},
        "cells": {
            "stiffness_n_per_m": between(2e5, 1e6),
            "gain_spread_fraction": between(0.1, 0.3),
            "offset_std_fraction": between(0.02, 0.08),
            "noise_std_n": between(*noise),
            "converter_bits": int(rng.integers(20, 25)),
        },
        "imu": {
            "mounting_error_std_rad": 0.001,
            "orientation_std_rad": between(0.00025, 0.001),
            "gyro_std_rad_per_s": 0.002,
            "accelerometer_std_mps2": 0.02,
        },
        "joints": {"encoder_resolution_rad": between(0.0002, 0.0015)},
    }


def middle_world() -> Sections:
    """The middle of what is drawn of perfect robots."""
    return {
        WHOLE: {"step_s": 0.01 / 3.0},
        "servo": {"full_torque_error_rad": 0.012, "damping_time_s": 0.03},
        "floor": {"friction": 0.9, "contact_time_s": 0.009},
        "cells": {
            "stiffness_n_per_m": 4.5e5,
            "gain_spread_fraction": 0.2,
            "offset_std_fraction": 0.05,
            "noise_std_n": NOISE_N,
            "converter_bits": 22,
        },
        "imu": {"orientation_std_rad": 0.0005},
        "joints": {"encoder_resolution_rad": 0.00055},
    }


def over_perfect(answer: Answer, strength: float) -> float:
    """A gap over its own world's floor, over the floor of a perfect one."""
    return AS_BUILT_FLOOR * strength if answer.as_built else strength


def write_world(path: Path, answer: Answer, items: Sequence[Mapping[str, Any]]) -> PlantVariation:
    """Write a set's reality file and read it: that of its base, changed.

    Args:
        path: of the file.
        answer: whose world it is.
        items: the effects it has, as a reality file lists them.
    """
    return write_reality(
        path, answer.world, items, base=answer.base, imu=answer.imu, built=answer.built
    )


def write_reality(
    path: Path,
    world: Mapping[str, Mapping[str, Any]],
    items: Sequence[Mapping[str, Any]] = (),
    *,
    base: str = PERFECT,
    imu: bool = True,
    built: float = 1.0,
) -> PlantVariation:
    """The same of any sections that were drawn, with or without inertial sensor.

    As-built errors are `built` times those of the base.
    """
    realities = config_dir() / "realities"
    default, merged = (
        copy.deepcopy(yaml.safe_load((realities / f"{name}.yaml").read_text()))
        for name in ("default", base)
    )
    for section, keys in AS_BUILT.items():
        own = merged.setdefault(section, {})
        own |= {key: _scaled(own.get(key, default[section][key]), built) for key in keys}
    for section, values in world.items():
        if section == WHOLE:
            merged |= values
        else:
            merged.setdefault(section, {}).update(values)
    merged.setdefault("imu", {})["present"] = imu
    write_yaml(path, {**merged, "name": path.stem, "effects": [dict(item) for item in items]})
    return load_reality(realities / "default.yaml", path)


def _scaled(value: Any, factor: float) -> Any:
    """A number, or all those of a table."""
    if isinstance(value, dict):
        return {key: _scaled(one, factor) for key, one in value.items()}
    if isinstance(value, list):
        return [_scaled(one, factor) for one in value]
    return factor * value
