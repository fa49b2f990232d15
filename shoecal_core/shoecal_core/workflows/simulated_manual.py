"""A manual calibration's readings from the simulated loading rig, which does the person's part."""

from __future__ import annotations

import numpy as np

from shoecal_core.manual.loads import CELLS, SHOE, Load, planned_loads
from shoecal_core.manual.measurements import LoadReading, Measurements
from shoecal_core.manual.settings import ManualSettings, load_manual_settings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.simulation.converter import ConvertedReadings
from shoecal_core.simulation.reality import PlantVariation
from shoecal_core.simulation.rig import LoadingRig
from shoecal_core.simulation.sampled_robot import draw_shoes
from shoecal_core.workspace import config_dir

SECOND_NS = 1_000_000_000
"""Simulated time has no epoch; each load takes a second of it."""


def simulate_manual(
    shoe: Shoe,
    reality: PlantVariation,
    robot_seed: int,
    seed: int,
    settings: ManualSettings | None = None,
) -> tuple[Measurements, Measurements]:
    """Readings of the single cells and of the shoe under weights.

    Args:
        shoe: as its file says.
        reality: how the simulated one differs.
        robot_seed: draws the cells: those of the robot of a session with the same `robot_seed`.
        seed: draws noise, and where exactly each weight stands.
        settings: weights and samples; None: those of the configuration.
    """
    if settings is None:
        settings = load_manual_settings(config_dir() / "manual.yaml")
    noise = np.random.default_rng([seed, 4])
    rig = LoadingRig(shoe, reality, draw_shoes(reality, shoe, robot_seed), noise)
    return read_rig(rig, CELLS, settings), read_rig(rig, SHOE, settings)


def read_rig(rig: LoadingRig, kind: str, settings: ManualSettings) -> Measurements:
    """Readings of a whole plan of loads, CELLS or SHOE, on the rig."""
    shoe = rig.shoe
    entries = []
    for index, load in enumerate(planned_loads(kind, shoe, settings.weights(kind)), start=1):
        own = rig_readings(rig, load, settings.samples).voltages[:, shoe.of_foot(load.foot)]
        mean, std = own.mean(axis=0), own.std(axis=0, ddof=1)
        entries.append(LoadReading(load, mean, std, len(own), index * SECOND_NS))
    return Measurements(kind, shoe, tuple(entries))


def rig_readings(rig: LoadingRig, load: Load, count: int) -> ConvertedReadings:
    """Readings (count, n) of the rig under a load."""
    if load.alone:
        return rig.cell_readings(load.mass, load.place, count=count)
    holes = rig.shoe.holes[load.foot]
    # The bare shoe's weight stands nowhere.
    place = np.zeros(2) if holes is None or not load.place else holes.position(load.place)
    return rig.readings(load.mass, load.foot, place, count=count)
