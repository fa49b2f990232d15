"""Names of error sources for a person, and what would make each of them smaller."""

from __future__ import annotations

NAMES = {
    "backlash": "play of the gears",
    "cell_position": "places of the cells",
    "gains_and_offsets": "gains and offsets left to the prior",
    "joint_compliance": "compliance of the gears",
    "joint_offset": "zeros of the joints",
    "link_com": "centres of mass of the links",
    "link_mass": "masses of the links",
    "noise": "noise and model form error",
    "placement": "feet that stand elsewhere in a run",
    "plates": "plates that carry load past the cells",
    "sideways_force": "sideways forces at the cells' height",
    "soft_ground": "soles that tilt under load",
    "support": "where the right foot stands",
    "time_offset": "time offset of the joints",
    "zero_offset": "zeros of single runs",
}
CURES = {
    "cell_position": "measure where the cells are, or calibrate the shoe manually",
    "plates": "calibrate the shoe manually, with known weights",
    "joint_offset": "calibrate the robot's joints",
    "link_com": "measure the links' balance points",
    "link_mass": "weigh the links",
    "joint_compliance": "measure how far the joints give under load",
    "backlash": "measure the play of the joints",
    "zero_offset": "lift each foot in every run",
    "soft_ground": "stand on a stiff floor",
}


def source_name(effect: str) -> str:
    """Its name for a person."""
    return NAMES.get(effect, effect.replace("_", " "))


def cure(effect: str) -> str | None:
    """What would make it smaller; None where nothing is known to."""
    return CURES.get(effect)
