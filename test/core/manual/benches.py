"""Shoes that can be loaded, and readings of them under a law that the test knows."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np

from core.shoe import mutations, shoes
from shoecal_core.arrays import FloatArray
from shoecal_core.manual.loads import CELLS, SHOE, Load, planned_loads
from shoecal_core.manual.measurements import LoadReading, Measurements
from shoecal_core.manual.settings import ManualSettings
from shoecal_core.manual.shoe_loads import expected_wrenches
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.shoe.wrench import ChannelParameters, weight_below
from shoecal_core.simulation.reality_file import load_reality

ROOT = Path(__file__).parents[3]
REALITIES = ROOT / "config" / "realities"
DEFAULT = load_reality(REALITIES / "default.yaml")
PERFECT = load_reality(REALITIES / "default.yaml", REALITIES / "perfect.yaml")
SETTINGS = ManualSettings(
    shoe_weights=(1.0, 2.5, 4.0),
    cell_weights=(1.0, 2.0),
    samples=5,
    still_fraction=1e-3,
    patience=20,
)
ODD_HOLES = {"x_m": [0.06, 0.03, 0.0, -0.03], "y_m": [0.008, 0.0, -0.008]}
"""Between the three cells of the odd pair's left shoe, and the six of its right."""


@cache
def nao_shoe() -> Shoe:
    return load_shoe(shoes.FILES["nao_shoe"])


@cache
def nao() -> Robot:
    return load_robot(ROOT / "config" / "robots" / "nao.yaml", nao_shoe())


def odd_shoe(folder: Path) -> Shoe:
    """The odd pair, with holes."""
    path = folder / "odd_shoe.yaml"
    edits = [(("feet", foot, "holes"), ODD_HOLES) for foot in FEET]
    return load_shoe(mutations.write_edited(path, shoes.FILES["odd_shoe"], *edits))


def some_law(shoe: Shoe, seed: int = 1) -> ChannelParameters:
    """Gains with the shoe's polarities, and offsets."""
    rng = np.random.default_rng(seed)
    count = len(shoe.names)
    sign = np.where(shoe.polarity == 0, 1, shoe.polarity)
    return ChannelParameters(sign * rng.uniform(8.0, 15.0, count), rng.uniform(-3.0, 3.0, count))


def read_cells(
    shoe: Shoe, law: ChannelParameters, weights: Sequence[float] = (2.0,)
) -> Measurements:
    """Single cells of a law, without noise."""
    entries = []
    for load in planned_loads(CELLS, shoe, weights):
        outputs = np.zeros(len(shoe.names))
        outputs[shoe.index(load.place)] = load.mass * GRAVITY
        entries.append(entry_of(shoe, load, (outputs - law.offset) / law.gain))
    return Measurements(CELLS, shoe, tuple(entries))


def read_shoe(
    shoe: Shoe, law: ChannelParameters, weights: Sequence[float] = (1.0, 2.5, 4.0)
) -> Measurements:
    """The shoe under every load, exactly where its file says: cells share it as springs do."""
    entries = []
    for load in planned_loads(SHOE, shoe, weights):
        outputs = np.zeros(len(shoe.names))
        channels = shoe.of_foot(load.foot)
        felt = floor_wrench(shoe, load) - weight_below(shoe)[load.foot]
        outputs[channels] = np.linalg.pinv(shoe.columns[channels].T) @ felt
        entries.append(entry_of(shoe, load, (outputs - law.offset) / law.gain))
    return Measurements(SHOE, shoe, tuple(entries))


def floor_wrench(shoe: Shoe, load: Load) -> FloatArray:
    """(3,) what the floor bears under a load."""
    holes = shoe.holes[load.foot]
    place = np.zeros(2) if holes is None or not load.place else holes.position(load.place)
    wrench: FloatArray = expected_wrenches(shoe, load.foot, np.array([load.mass]), place[None])[0]
    return wrench


def entry_of(shoe: Shoe, load: Load, readings: FloatArray, std: float = 1e-3) -> LoadReading:
    """A mean of ten samples of all channels (n,)."""
    own = readings[shoe.of_foot(load.foot)]
    return LoadReading(load, own, np.full(len(own), std), 10, 1_000_000_000)


def changed(measurements: Measurements, load: Load, **values: object) -> Measurements:
    """The same with one entry's fields changed."""
    entries = tuple(
        dataclasses.replace(entry, **values) if entry.load == load else entry  # type: ignore[arg-type]
        for entry in measurements.entries
    )
    return dataclasses.replace(measurements, entries=entries)


def without(measurements: Measurements, *loads: Load) -> Measurements:
    """The same with some entries less."""
    entries = tuple(entry for entry in measurements.entries if entry.load not in loads)
    return dataclasses.replace(measurements, entries=entries)
