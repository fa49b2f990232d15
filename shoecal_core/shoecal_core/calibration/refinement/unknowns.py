"""What may be wrong about robot and shoes, each with what is believed of its size.

Everything is linear near zero: an unknown of the body moves the modelled CoP, one of the shoes
changes what one unit of an output means (its column).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.refinement.found_effects import FoundEffect
from shoecal_core.calibration.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.model.robot import Robot
from shoecal_core.sensing.shoe import FEET, Shoe

FloatArray = NDArray[np.float64]

ALL = "all"
COMPLIANCE_STD, PLAY_STD = 0.005, 0.003
"""rad/(N m) of gears, rad of their whole dead band: what is usual in small robots."""
BODY = frozenset({"joint_offset", "joint_compliance", "backlash", "link_com", "payload"})
"""Effects that move the modelled CoP: they clean the reference and are no part of the result."""
GEARS = frozenset({"joint_compliance", "backlash"})
"""Effects of those for which torques of the joints must be known."""
MEASURING = frozenset({"cell_position", "crosstalk", "plates"})
"""Effects that change columns: they are part of the calibration, and `/shoe/cop` uses them.
`plates` is the part of a foot's moment that its plates carry past the cells."""
COMPONENTS = {
    "joint_offset": {"angle"}, "joint_compliance": {"compliance"}, "backlash": {"play"},
    "link_com": {"x", "y", "z"}, "payload": {"mass"},
    "cell_position": {"x", "y"}, "crosstalk": {"fraction"}, "plates": {"share_x", "share_y"},
}  # fmt: skip
"""Of each effect's size."""


@dataclass(frozen=True)
class Unknown:
    """One number.

    Attributes:
        effect, location, component: as in a diagnosis; lumped links go by their joint's name.
        mean, std: what is believed of it beforehand, in SI units.
    """

    effect: str
    location: tuple[str, ...]
    component: str
    mean: float
    std: float

    @property
    def name(self) -> tuple[str, tuple[str, ...], str]:
        """What it is known by."""
        return self.effect, self.location, self.component


def tolerated(
    robot: Robot, shoe: Shoe, links: Sequence[str], tolerances: Tolerances, *, efforts: bool
) -> list[Unknown]:
    """Everything that files of robot and shoes may be wrong by.

    Args:
        links: names of the joints that carry a link with a mass.
        efforts: whether torques of the joints were recorded; else nothing is said of gears.
    """
    found = [
        Unknown("joint_offset", (name,), "angle", 0.0, tolerances.joint_zero_rad)
        for name in robot.leg_names
    ]
    if efforts:
        found += [
            Unknown("joint_compliance", (ALL,), "compliance", 0.0, COMPLIANCE_STD),
            Unknown("backlash", (ALL,), "play", 0.0, PLAY_STD),
        ]
    found += [
        Unknown("link_com", (link,), axis, 0.0, tolerances.link_com_m)
        for link in links
        for axis in "xyz"
    ]
    found += list(_of_shoes(shoe, tolerances))
    return [one for one in found if one.std > 0.0]


def with_found(unknowns: Sequence[Unknown], found: Sequence[FoundEffect]) -> list[Unknown]:
    """The same; what a diagnosis found of their sizes is believed instead, and added.

    A diagnosis fitted few effects where here many are: each size is believed no better than by
    itself, nor than the tolerance that there is for it anyway.

    Raises:
        ShoecalError: an effect with another number of places, or with other components.
    """
    believed = {one.name: one for one in unknowns}
    for effect in found:
        _check(effect)
        for component, (mean, std) in effect.size.items():
            open_std = max(std, abs(mean), 1e-12)
            told = Unknown(effect.effect, effect.location, component, mean, open_std)
            before = believed.get(told.name)
            if before is not None:
                told = replace(told, std=max(open_std, before.std))
            believed[told.name] = told
    return list(believed.values())


def as_if_unseen(effect: FoundEffect) -> FoundEffect:
    """The same, its size zero give or take what was found.

    For asking readings whether it is there at all, when they are those that it was found in.
    """
    size = {name: (0.0, max(std, abs(mean))) for name, (mean, std) in effect.size.items()}
    return replace(effect, size=size)


def can_be_fitted(effect: FoundEffect) -> bool:
    """Whether an effect is among those that a refinement knows."""
    return effect.effect in BODY | MEASURING and not (
        effect.effect == "crosstalk" and len({cell.split("/")[0] for cell in effect.location}) > 1
    )


def _check(effect: FoundEffect) -> None:
    places = 2 if effect.effect == "crosstalk" else 1
    if len(effect.location) != places:
        raise ShoecalError(
            f"the diagnosis' {effect.label} needs {places} in its location; diagnose anew"
        )
    if not effect.size.keys() <= COMPONENTS[effect.effect]:
        listed = ", ".join(sorted(COMPONENTS[effect.effect]))
        raise ShoecalError(
            f"the diagnosis' {effect.label} has a size of other components than {listed}; "
            "diagnose anew"
        )


def column_change(unknown: Unknown, shoe: Shoe) -> FloatArray:
    """(n, 3) by which one unit changes the channels' columns, in their own foot's frame."""
    change = np.zeros((len(shoe.names), 3))
    axis = "xy".find(unknown.component[-1:])
    if unknown.effect == "cell_position":
        cell = shoe.index(unknown.location[0])
        change[cell] = shoe.columns[cell, 0] * _moved(axis, 1.0)
    elif unknown.effect == "crosstalk":
        receiver, donor = (shoe.index(name) for name in unknown.location)
        change[donor] = -shoe.columns[receiver]
    else:
        own = _cells(shoe, FEET.index(unknown.location[0]))
        places = shoe.positions[own, axis]
        for cell, lever in zip(own, places - places.mean(), strict=True):
            change[cell] = shoe.columns[cell, 0] * _moved(axis, float(lever))
    return change


def _of_shoes(shoe: Shoe, tolerances: Tolerances) -> Iterator[Unknown]:
    for foot, side in enumerate(FEET):
        cells = _cells(shoe, foot)
        for cell in cells:
            for axis in "xy":
                yield Unknown(
                    "cell_position", (shoe.names[cell],), axis, 0.0, tolerances.cell_position_m
                )
        if len(cells) >= 3:
            for axis in "xy":
                yield Unknown("plates", (side,), f"share_{axis}", 0.0, 2.0 * tolerances.plate_share)


def _cells(shoe: Shoe, foot: int) -> NDArray[np.int64]:
    own = shoe.of_foot(foot)
    felt: NDArray[np.int64] = own[shoe.columns[own, 0] != 0.0]
    return felt


def _moved(axis: int, length: float) -> FloatArray:
    """(3,) column of a force that acts farther along x or y by a length."""
    return np.array([0.0, 0.0, -length] if axis == 0 else [0.0, length, 0.0])
