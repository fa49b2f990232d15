"""How far a robot that works may be off its files: the as-built standard deviation of each source.

Every robot has all of these errors. Calibration and checks take them from here alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from shoecal_core.settings import Settings, setting

MOST = {"m": 0.1, "rad": 0.5, "s": 1.0, "": 1.0}
"""By unit: no robot that stands is so far off its files; larger ones are in mm, degrees, ms, %."""


def _tolerance(default: float, unit: str, doc: str) -> float:
    """A field that cannot be below zero, or above what is possible."""
    return setting(default, unit, doc, minimum=0.0, maximum=MOST.get(unit, math.inf))


@dataclass(frozen=True)
class Tolerances(Settings):
    """As-built standard deviations; 0 takes a source for exact."""

    link_mass: float = _tolerance(
        0.02, "", "each link's mass, as a share of it; the total is weighed"
    )
    link_com_m: float = _tolerance(0.003, "m", "each link's centre of mass, each axis")
    joint_zero_rad: float = _tolerance(0.004, "rad", "zero of each leg joint's encoder")
    gear_compliance_rad_per_nm: float = _tolerance(
        0.005, "rad/(N m)", "compliance of the leg joints' gears, of all together; for a robot of "
        "52 N, less for heavier ones"
    )  # fmt: skip
    gear_play_rad: float = _tolerance(
        0.003, "rad", "play of the leg joints' gears, of all together"
    )
    gear_friction_rad: float = _tolerance(
        0.006, "rad", "by which the leg joints' links lag, from one way of motion to the other, as "
        "gears with play give under friction, of all together; diagnosis only"
    )  # fmt: skip
    gear_spread: float = _tolerance(
        0.5, "", "how far the gears of single joints differ from each other, as a share of both"
    )  # fmt: skip
    sole_compliance_rad_per_nm: float = _tolerance(
        0.003, "rad/(N m)", "tilt of a shoe under a moment, by its cells and the floor; for a "
        "robot of 52 N"
    )  # fmt: skip
    cell_position_m: float = _tolerance(0.0015, "m", "where each channel acts, each axis")
    plate_share: float = _tolerance(
        0.1, "", "part of a foot's moment that its plates carry past the cells"
    )
    run_zero_n: float = _tolerance(
        0.05, "N", "zero of each channel in one run against the session's; a moment's a tenth of "
        "it, in N m"
    )  # fmt: skip
    support_m: float = _tolerance(
        0.0008, "m", "where the right foot stands in each run, beyond what the joints explain"
    )  # fmt: skip
    support_rad: float = _tolerance(0.006, "rad", "the same of its yaw")
    sideways_share: float = _tolerance(
        0.045, "", "sideways force between the feet as a share of the weight: at the cells' "
        "height it moves each foot's CoP, and no cell feels it"
    )  # fmt: skip
    floor_tilt_rad: float = _tolerance(
        0.002, "rad", "slope of the floor about each axis; diagnosis only"
    )
    delay_s: float = _tolerance(
        0.015,
        "s",
        "by which readings of both shoes are later than joint angles of the same stamp, and links "
        "than their motors; diagnosis only",
    )
    foot_placement_m: float = _tolerance(
        0.001, "m", "where a shoe sits below its ankle, each axis; diagnosis only"
    )
    foot_placement_rad: float = _tolerance(0.006, "rad", "the same of its yaw; diagnosis only")
    crosstalk: float = _tolerance(
        0.01, "", "part of its range by which one axis of a six-axis sensor shows in another; of "
        "one cell's force in another one of its foot, in a diagnosis only"
    )  # fmt: skip
