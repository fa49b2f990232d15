"""What the files of robot and shoes say that may be right and mostly is not."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.leg_masses import unlike_masses
from shoecal_core.robot.robot import Robot, first_link
from shoecal_core.robot.sole_places import MisplacedSole, misplaced_soles, off_bounds
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET, Shoe

SHOE_SHARE = 0.1
"""Share of the whole mass from which shoes are rather given in another unit, or with a slip of the
decimal point: those of the paper are 3 % of their NAO."""
SAME_PLACE_M = 0.0005
"""Places are given in whole or half millimetres."""
NOTABLE_M = 0.002
"""By which mirrored and unmirrored places differ at least before one of them is wrong: somewhat
more than the tolerance of a cell's place."""

_WAYS = (("ahead", "behind"), ("to the left", "to the right"))
"""Along x and along y of the sole frame, to its positive and its negative end."""


def check_files(robot: Robot, shoe: Shoe) -> list[Finding]:
    """Shoes that are too heavy, cells of the other foot or off the soles, soles off the feet's
    shapes, and legs of unlike masses.
    """
    found = []
    share = shoe.mass / robot.mass
    if share > SHOE_SHARE:
        found.append(
            f"the plates of both shoes have {shoe.mass:.3g} kg by the shoe file, {share:.0%} of "
            f"the {robot.mass:.3g} kg of robot and shoes: put the shoes on a scale, and correct "
            "mass_above_kg and mass_below_kg"
        )
    if (apart := _not_mirrored(robot, shoe)) > NOTABLE_M:
        found.append(
            "the right foot's cells have the places of the left foot's, though the soles are each "
            f"other's mirror images: up to {1e3 * apart:.0f} mm apart from mirrored ones; give "
            "the right ones' y with the other sign (position_m in the shoe file), unless both "
            "shoes are of the same shape"
        )
    found += _off_soles(robot, shoe)
    found += _off_shape(misplaced_soles(robot))
    # Legs of which one has a joint more are counted from the feet.
    pairs = zip(*(reversed(leg) for leg in robot.leg_chains), strict=False)
    for left, right, masses in unlike_masses(robot.model, pairs, robot.mass):
        names = " and ".join(first_link(robot.model, joint).name for joint in (left, right))
        found.append(
            f"{names} are {masses[0]:.3g} and {masses[1]:.3g} kg by the URDF, though the legs are "
            "alike: correct the <mass> of the wrong one"
        )
    return [Finding("WARN", text) for text in found]


def _off_shape(soles: list[MisplacedSole]) -> list[str]:
    """By how much soles are off the shapes of their feet: once where both are alike."""
    feet: dict[tuple[str, str], list[str]] = {}
    for sole in soles:
        added = ", ".join(f"{value:g}" for value in np.round(sole.cure, 3) + 0.0)
        feet.setdefault((_ways(sole.offset), added), []).append(sole.foot)
    return [
        f"the outline of the {' and the '.join(names)} sole is {ways} of the shape that the URDF "
        "gives the foot, and leaves as much of it free on the other side: the CoP is off by that; "
        f"add [{added}] to feet.{' and feet.'.join(f'{name}.sole_xyz_m' for name in names)} of the "
        "robot file, unless outline_m alone is wrong"
        for (ways, added), names in feet.items()
    ]


def _off_soles(robot: Robot, shoe: Shoe) -> list[str]:
    """By how much cells are off the soles that they are to measure: once where feet are alike.

    Cells of both feet that are shifted alike move the CoP of a robot on both feet as their zeros
    do: no fit would notice.
    """
    feet: dict[str, list[str]] = {}
    for index, foot in enumerate(robot.feet):
        places = shoe.positions[shoe.vertical & (shoe.foot == index)]
        # A six-axis sensor measures what acts elsewhere, too.
        offset = off_bounds(places, foot.outline) if len(places) > 1 else np.zeros(2)
        if offset.any():
            feet.setdefault(_ways(offset), []).append(FEET[index])
    return [
        f"the cells of the {' and the '.join(names)} foot stand out of the sole's outline, and "
        f"leave as much of it free on the other side: their middle is {ways} of the outline's; "
        "position_m in the shoe file and outline_m in the robot file are both in the sole frame, "
        "so one of them has another origin (the heel, the ankle): correct it, or the CoP of each "
        "foot is off by that"
        for ways, names in feet.items()
    ]


def _ways(offset: FloatArray) -> str:
    """An offset (2,) in the sole frame [m], in words."""
    return " and ".join(
        f"{1e3 * abs(by):.0f} mm {way[int(by < 0.0)]}"
        for by, way in zip(offset, _WAYS, strict=True)
        if by
    )


def _not_mirrored(robot: Robot, shoe: Shoe) -> float:
    """How far the right cells are from the mirrored left ones, where they have the left ones'
    places and the soles are mirrored [m]; else 0.
    """
    soles = [foot.outline for foot in robot.feet]
    left, right = (
        np.array([shoe.channels[index].position for index in shoe.of_foot(foot)])
        for foot in range(2)
    )
    mirrored_soles = _apart(_mirrored(soles[0]), soles[1]) < SAME_PLACE_M
    if not mirrored_soles or _apart(*soles) < NOTABLE_M or _apart(left, right) > SAME_PLACE_M:
        return 0.0
    return _apart(_mirrored(left), right)


def _mirrored(places: FloatArray) -> FloatArray:
    """(n, 2) of the other foot."""
    return places * (1.0, -1.0)


def _apart(ours: FloatArray, theirs: FloatArray) -> float:
    """From any of (n, 2) places to the nearest of (k, 2) others, at most, either way [m]."""
    distances = np.linalg.norm(ours[:, None] - theirs[None], axis=2)
    return float(max(distances.min(axis=0).max(), distances.min(axis=1).max()))
