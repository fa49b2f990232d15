"""Double supports that people ask for by name."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from shoecal_core.errors import NameNotFoundError
from shoecal_core.planning.supports.feasible import Feasible, SupportRangeError, feet_distance
from shoecal_core.robot.double_support import DoubleSupport


@dataclass(frozen=True)
class NamedSupport:
    """What a name means.

    Attributes:
        doc: for people.
        most: what it has the most of within a robot's range; None for neutral itself.
    """

    doc: str
    most: Callable[[DoubleSupport], float] | None


NAMED: Mapping[str, NamedSupport] = {
    "neutral": NamedSupport("as in normal standing", None),
    "toes_in": NamedSupport("turned inward as far as can be", lambda at: at.dtheta),
    "toes_out": NamedSupport("turned outward as far as can be", lambda at: -at.dtheta),
    "wide": NamedSupport("as far apart as can be", lambda at: -at.dy),
    "left_ahead": NamedSupport("the left foot ahead as far as can be", lambda at: -at.dx),
    "right_ahead": NamedSupport("the right foot ahead as far as can be", lambda at: at.dx),
}


PAPER = tuple(
    DoubleSupport(*pose)
    for pose in (
        (0.0002, -0.0994, 0.0), (0.07, -0.0997, 0.1487), (-0.0543, -0.1079, 0.1483),
        (0.0201, -0.1099, -0.4507), (-0.066, -0.0903, -0.4515),
        (-0.03, -0.13, -0.0995), (0.0169, -0.1323, -0.1), (-0.0281, -0.1424, 0.151),
        (0.0492, -0.1366, 0.1491),
    )
)  # fmt: skip
"""Of a NAO, five to train and four to test: from the repository of the paper's authors."""
PAPER_DOC = "the paper's nine of a NAO, five to train, then four to test"
_TRIED = 4
"""Of those that have equally much; to try all takes minutes."""


def named_supports(name: str, feasible: Feasible) -> list[DoubleSupport]:
    """As `named_support`; `paper` names several."""
    return list(PAPER) if name == "paper" else [named_support(name, feasible)]


def named_support(name: str, feasible: Feasible) -> DoubleSupport:
    """The double support of a robot's range that a name means.

    Of those that have equally much of it, one of the few nearest to neutral.

    Args:
        name: one of NAMED.
        feasible: of the robot.

    Raises:
        NameNotFoundError: for another name.
        SupportRangeError: when the robot can stand nowhere in its range.
    """
    if name not in NAMED:
        raise NameNotFoundError("stance", name, tuple(NAMED))
    most, settings = NAMED[name].most, feasible.settings
    neutral = feasible.robot.neutral
    if most is None:
        return neutral

    def away(support: DoubleSupport) -> float:
        way = np.array([support.dx - neutral.dx, support.dy - neutral.dy])
        return float(feet_distance(way, support.dtheta - neutral.dtheta, settings))

    alike: defaultdict[float, list[DoubleSupport]] = defaultdict(list)
    for support in feasible.apart():
        alike[most(support)].append(support)
    for much in sorted(alike, reverse=True):
        for support in sorted(alike[much], key=away)[:_TRIED]:
            if feasible.can_stand(support):
                return support
    raise SupportRangeError(feasible, 0, 1)
