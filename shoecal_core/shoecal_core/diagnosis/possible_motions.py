"""What could be done next: the catalogue of motions, and what needs a person or time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from shoecal_core.error_sources.effects.contact import TURNED
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.named import named_support
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.samples.known_weight import KNOWN_MASS, WEIGHTED

WARM, YAWED = "warm_up", "yawed_stance"
STANCES: Mapping[str, tuple[str, ...]] = {
    YAWED: ("toes_in", "toes_out"),
    "wide_stance": ("wide",),
    "left_foot_ahead": ("left_ahead",),
    "right_foot_ahead": ("right_ahead",),
}
"""STANCE_MOTION in a double support of such a name (`planning.supports.named`), the one of several
that is farther in yaw from those so far."""
STANCE_MOTION = "landmarks"
"""What the robot does there."""


@dataclass(frozen=True)
class ByHand:
    """A motion of the catalogue that needs more than the robot.

    Attributes:
        motion: in the catalogue.
        later: time that passes before [s].
        mass: that a person adds [kg].
        warmer: by then [K].
    """

    motion: str
    later: float = 1.0
    mass: float = 0.0
    warmer: float = 0.0


BY_HAND: Mapping[str, ByHand] = {
    TURNED: ByHand("landmarks"),
    WARM: ByHand("hold", later=600.0, warmer=3.0),
    WEIGHTED: ByHand("landmarks", mass=KNOWN_MASS),
}
"""In addition to the catalogue; see docs/reference/nodes.md for what a person does."""


def stance(name: str, feasible: Feasible, so_far: Sequence[DoubleSupport]) -> DoubleSupport:
    """The double support of one of STANCES, for a session that has been in some so far."""
    return max(
        (named_support(one, feasible) for one in STANCES[name]),
        key=lambda one: min((abs(one.dtheta - other.dtheta) for other in so_far), default=0.0),
    )
