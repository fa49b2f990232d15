"""Why a robot cannot stand somewhere: which of its bounds rule it out, and by how much."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.freedom import missing_ankle
from shoecal_core.planning.legs import BALANCE_NAMES
from shoecal_core.robot.robot import Robot

_MOST = 4.0
"""Of the measure of `Loose`; what is ruled out then is by no bound."""
_HALVINGS = 8
"""Of it, to find the least that suffices."""
_PARTS = ("torque", "limits", "clearance", "balance")
_PRICES = (1.0, 1.5, 2.0, 2.0)
"""One kind of bound is to blame rather than two, even where it has to be widened by more."""


@dataclass(frozen=True)
class Loose:
    """By how much bounds of a posture are widened, each in its own measure; negative: narrowed.

    Attributes:
        torque: of what motors may need, by that part of it.
        limits: of the joints, on either side [0.3 rad].
        clearance: between parts of the robot [20 mm].
        balance: of load, grip and edges of the feet, and the torso's tilt [2 % of the weight].
    """

    torque: float = 0.0
    limits: float = 0.0
    clearance: float = 0.0
    balance: float = 0.0

    @property
    def torque_factor(self) -> float:
        """On the torques that motors may need."""
        return 1.0 + self.torque

    @property
    def limits_rad(self) -> float:
        """Beyond the joints' limits."""
        return 0.3 * self.limits

    @property
    def clearance_m(self) -> float:
        """Less than the least distance."""
        return 0.02 * self.clearance

    @property
    def balance_share(self) -> float:
        """Less than the least of `BALANCE_NAMES`."""
        return 0.02 * self.balance


BOUND = Loose()
"""All bounds as they are."""


@dataclass(frozen=True)
class Excess:
    """What a posture asks for beyond its bounds as they are; less than zero where it keeps them.

    Attributes:
        balance: (13,) of `BALANCE_NAMES`.
        clearance: (p,) of the robot's collision pairs [m].
        torque: (k,) of the legs' motors [N m].
        limits: (k,) of the legs' joints [rad].
    """

    balance: FloatArray
    clearance: FloatArray
    torque: FloatArray
    limits: FloatArray


@dataclass(frozen=True)
class Obstacle:
    """What keeps a robot from standing somewhere.

    Attributes:
        what: in words.
        cure: likewise.
    """

    what: str
    cure: str


def obstacle(robot: Robot, tried: Callable[[Loose], Excess | None]) -> Obstacle:
    """The bounds that have to be widened least so that a robot could stand there; rather few.

    Args:
        robot: whose legs.
        tried: what a posture asks for where bounds are loosened; None where there is none.
    """
    best, least, excess = BOUND, _MOST, None
    for count, price in enumerate(_PRICES, start=1):
        for parts in itertools.combinations(_PARTS, count):
            found = _widened(parts, least / price, tried)
            if found is not None:
                best, excess = found
                least = price * max(getattr(best, part) for part in _PARTS)
    if excess is None:
        return Obstacle(
            f"its legs' joints do not bring the soles and the CoM there{missing_ankle(robot)}",
            "see that 'legs' of the robot file names every joint of both legs",
        )
    blamed = _parts(robot, best, excess)
    whats, cures = (one.what for one in blamed), (one.cure for one in blamed)
    return Obstacle(" and ".join(whats), "; ".join(cures))


def _widened(
    parts: Collection[str], most: float, tried: Callable[[Loose], Excess | None]
) -> tuple[Loose, Excess] | None:
    """The least widening of some kinds of bounds that suffices; None where more than `most` is
    needed.
    """
    low, high = 0.0, most
    loose = Loose(**dict.fromkeys(parts, high))
    excess = tried(loose)
    if excess is None:
        return None
    for _ in range(_HALVINGS):
        between = (low + high) / 2.0
        closer = Loose(**dict.fromkeys(parts, between))
        if (found := tried(closer)) is None:
            low = between
        else:
            high, loose, excess = between, closer, found
    return loose, excess


def _parts(robot: Robot, loose: Loose, excess: Excess) -> list[Obstacle]:
    """One for each kind of bound that is loosened, and made use of."""
    found = []
    if loose.torque > 0.0 and np.max(excess.torque) > 0.0:
        motor = int(np.argmax(excess.torque))
        limit = float(robot.effort_limit[robot.legs][motor])
        found.append(
            Obstacle(
                f"{robot.leg_names[motor]} would need {excess.torque[motor]:.2g} N m more than "
                f"torque_share of its {limit:.3g} N m",
                "see that the URDF's effort limits are those of the motors, or raise torque_share",
            )
        )
    if loose.limits > 0.0 and np.max(excess.limits) > 0.0:
        joint = int(np.argmax(excess.limits))
        found.append(
            Obstacle(
                f"{robot.leg_names[joint]} would turn {excess.limits[joint]:.2g} rad beyond its "
                "limits and their margins",
                "see that these limits are the robot's own, or lower stance_margin, joint_margin "
                "or knee_margin",
            )
        )
    if loose.balance > 0.0 and np.max(excess.balance) > 0.0:
        found.append(
            Obstacle(
                f"{BALANCE_NAMES[int(np.argmax(excess.balance))]} is not kept",
                "bring support_range nearer to the neutral stance, or see that masses, friction "
                "and sensing polygons are the robot's own",
            )
        )
    if loose.clearance > 0.0 and np.max(excess.clearance) > 0.0:
        a, b = robot.collision_pairs[int(np.argmax(excess.clearance))]
        one, other = robot.capsules[a].name, robot.capsules[b].name
        found.append(
            Obstacle(
                f"{one} and {other} would be {1e3 * excess.clearance.max():.2g} mm too near",
                "see that the capsules are no thicker than the legs, or lower capsule_clearance",
            )
        )
    return found
