"""How far a robot that works may be off its files: the as-built standard deviation of each source.

Every robot has all of these errors. Calibration and checks take them from here alone.
"""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.settings import Settings, setting


@dataclass(frozen=True)
class Tolerances(Settings):
    """As-built standard deviations; 0 takes a source for exact."""

    link_mass: float = setting(
        0.02, "", "each link's mass, as a share of it; the total is weighed", minimum=0.0
    )
    link_com_m: float = setting(0.003, "m", "each link's centre of mass, each axis", minimum=0.0)
    joint_zero_rad: float = setting(0.004, "rad", "zero of each leg joint's encoder", minimum=0.0)
    gear_compliance_rad_per_nm: float = setting(
        0.005, "rad/(N m)", "compliance of the leg joints' gears, of all together; for a robot of "
        "52 N, less for heavier ones", minimum=0.0,
    )  # fmt: skip
    gear_play_rad: float = setting(
        0.003, "rad", "play of the leg joints' gears, of all together", minimum=0.0
    )
    gear_friction_rad: float = setting(
        0.006, "rad", "by which the leg joints' links lag, from one way of motion to the other, as "
        "gears with play give under friction, of all together; diagnosis only", minimum=0.0,
    )  # fmt: skip
    gear_spread: float = setting(
        0.5, "", "how far the gears of single joints differ from each other, as a share of both",
        minimum=0.0,
    )  # fmt: skip
    sole_compliance_rad_per_nm: float = setting(
        0.003, "rad/(N m)", "tilt of a shoe under a moment, by its cells and the floor; for a "
        "robot of 52 N", minimum=0.0,
    )  # fmt: skip
    cell_position_m: float = setting(0.0015, "m", "where each channel acts, each axis", minimum=0.0)
    plate_share: float = setting(
        0.1, "", "part of a foot's moment that its plates carry past the cells", minimum=0.0
    )
    run_zero_n: float = setting(
        0.05, "N", "zero of each channel in one run against the session's; a moment's a tenth of "
        "it, in N m", minimum=0.0,
    )  # fmt: skip
    support_m: float = setting(
        0.0008, "m", "where the right foot stands in each run, beyond what the joints explain",
        minimum=0.0,
    )  # fmt: skip
    support_rad: float = setting(0.006, "rad", "the same of its yaw", minimum=0.0)
    sideways_share: float = setting(
        0.045, "", "sideways force between the feet as a share of the weight: at the cells' "
        "height it moves each foot's CoP, and no cell feels it", minimum=0.0,
    )  # fmt: skip
    floor_tilt_rad: float = setting(
        0.002, "rad", "slope of the floor about each axis; diagnosis only", minimum=0.0
    )
    delay_s: float = setting(
        0.015,
        "s",
        "by which readings of both shoes are later than joint angles of the same stamp, and links "
        "than their motors; diagnosis only",
        minimum=0.0,
    )
    foot_placement_m: float = setting(
        0.001, "m", "where a shoe sits below its ankle, each axis; diagnosis only", minimum=0.0
    )
    foot_placement_rad: float = setting(
        0.006, "rad", "the same of its yaw; diagnosis only", minimum=0.0
    )
    crosstalk: float = setting(
        0.01, "", "part of its range by which one axis of a six-axis sensor shows in another; of "
        "one cell's force in another one of its foot, in a diagnosis only", minimum=0.0,
    )  # fmt: skip
