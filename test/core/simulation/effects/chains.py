"""Effects as a reality file lists them, and forces sent through the shoes that have them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np

from core.simulation.worlds import PERFECT, ROOT, changed, load_world
from shoecal_core.arrays import FloatArray
from shoecal_core.files import Fields
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation.effects.effect import Effect
from shoecal_core.simulation.effects.registry import read_effect
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.sampled_robot import draw_shoes
from shoecal_core.simulation.sensor_chain import NO_SIDEWAYS, SensorChain

PERIOD = 0.01
"""s; between two instants."""
NAO = load_world("nao").shoe
SIX_AXIS = load_shoe(ROOT / "config" / "shoes" / "reemc.yaml")


def item(name: str, *location: str, **sizes: float) -> Effect:
    """An effect, read as from a file; no location where it has none."""
    listed: dict[object, object] = {"effect": name}
    listed.update(sizes)
    if location:
        listed["location"] = list(location)
    return read_effect(Fields(Path("mine.yaml"), "effects[0]", listed))


def warm(rise: float, time: float = 100.0) -> PlantVariation:
    """A perfect world in which shoes warm up."""
    shoes = dataclasses.replace(PERFECT.shoes, warm_up_k=rise, warm_up_time_s=time)
    return dataclasses.replace(PERFECT, shoes=shoes)


def shoes_with(*effects: Effect, shoe: Shoe = NAO, rules: PlantVariation = PERFECT) -> SampledShoes:
    """Shoes with effects."""
    return draw_shoes(changed(rules, *effects), shoe, 1)


def through(
    shoes: SampledShoes, forces: FloatArray, *, period: float = PERIOD,
    sideways: FloatArray = NO_SIDEWAYS,
) -> FloatArray:  # fmt: skip
    """(T, n) what reaches the converter of forces (T, n) [N], an instant a period from 0 on."""
    chain, reached = SensorChain(shoes), []
    for index, felt in enumerate(forces):
        chain.take(felt, index * period, sideways)
        reached.append(chain.latest())
    return np.array(reached)


def on_first(shoe: Shoe, force: FloatArray) -> FloatArray:
    """(T, n) forces: one course (T,) on the first channel, nothing on the others."""
    forces = np.zeros((len(force), len(shoe.channels)))
    forces[:, 0] = force
    return forces
