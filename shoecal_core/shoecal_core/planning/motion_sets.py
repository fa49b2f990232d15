"""Sets of motions by name: which motion in which double support, to train or to test."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from shoecal_core.errors import ShoecalError
from shoecal_core.planning.motion_catalogue import motion_kind
from shoecal_core.robot.double_support import DoubleSupport

TRAIN, TEST = "train", "test"
UNLOADING = ("unload_left", "unload_right")
"""Motions that lift a foot."""


@dataclass(frozen=True)
class MotionSet:
    """Motions that are recorded as one session, a run each.

    Attributes:
        doc: what it is for, for people.
        train: names in the motion catalogue, of the runs that are fitted.
        test: of the runs that test the fit.
    """

    doc: str
    train: tuple[str, ...]
    test: tuple[str, ...] = ("landmarks", "reversed")

    def __len__(self) -> int:
        return len(self.train) + len(self.test)

    @property
    def runs(self) -> tuple[tuple[str, str], ...]:
        """Motion and hint of each run."""
        return tuple((motion, hint) for hint, motions in self._by_hint for motion in motions)

    @property
    def _by_hint(self) -> tuple[tuple[str, tuple[str, ...]], ...]:
        return (TRAIN, self.train), (TEST, self.test)


STANDARD, THOROUGH = "standard", "thorough"
MOTION_SETS: Mapping[str, MotionSet] = {
    # A minute of motion: as accurate as the thorough set's two within 0.05 mm. Unloading in another
    # double support than the neutral one costs 0.1 mm.
    STANDARD: MotionSet(
        "for a calibration: round the landmarks 1.8 times as fast, each foot lifted once",
        ("faster", "faster_reversed", "unload_left", "unload_right"),
    ),
    # Effects of joints and links show by direction and height; a calibration needs neither.
    THOROUGH: MotionSet(
        "for a diagnosis: both directions, two heights of the torso, each foot lifted once",
        ("landmarks", "reversed", "torso_height", "unload_left", "unload_right"),
    ),
}
"""By name. Both test slowly and where nothing was trained, so that their errors compare."""

STANDARD_SUPPORTS = 5
"""Double supports of a set: three to train in, two to test in."""
_TRAIN_SUPPORTS = 3
"""Fewer do not fix every direction of gains and offsets."""


@dataclass(frozen=True)
class PlannedRun:
    """A run to be recorded.

    Attributes:
        support: where.
        motion: name in the motion catalogue.
        hint: what it is meant for: `train`, `test`, or empty.
    """

    support: DoubleSupport
    motion: str
    hint: str = ""


def set_runs(
    name: str, supports: Sequence[DoubleSupport], neutral: DoubleSupport
) -> tuple[PlannedRun, ...]:
    """A set of motions in double supports, as it is recorded.

    Training and testing take turns from yaw to yaw: runs to train begin and end the range of yaw
    between the feet, and a run to test stands where no other does, in between. Fewer than four
    double supports leave none for tests alone: those are then shared, with other motions. Each foot
    is unloaded in the neutral support: there any robot can stand on one foot that can do so at all,
    and its motors and joints give least.

    Args:
        name: in MOTION_SETS.
        supports: double supports that differ in yaw; STANDARD_SUPPORTS of them are best.
        neutral: as in normal standing.

    Raises:
        ShoecalError: for no supports.
    """
    _require(supports)
    tested = _test_supports(supports)
    # The ends of the yaw's range first: a set may have fewer motions than there are supports.
    yaws = sorted(support.dtheta for support in supports)
    trained = sorted(
        (support for support in supports if support not in tested),
        key=lambda support: support.dtheta not in (yaws[0], yaws[-1]),
    )
    # Where both share them, tests move on by one, so that each meets another motion's support.
    places = {
        TRAIN: itertools.cycle(trained),
        TEST: itertools.cycle(tested or [*trained[1:], trained[0]]),
    }
    return tuple(
        PlannedRun(neutral if motion in UNLOADING else next(places[hint]), motion, hint)
        for motion, hint in MOTION_SETS[name].runs
    )


def listed_runs(
    supports: Sequence[DoubleSupport], motions: Sequence[str]
) -> tuple[PlannedRun, ...]:
    """One run of each motion, in the double supports in turn.

    Raises:
        ShoecalError: without supports or motions.
        NameNotFoundError: for a motion that is not in the catalogue.
    """
    _require(supports)
    if not motions:
        raise ShoecalError("no motions are named; name at least one")
    for motion in motions:
        motion_kind(motion)
    return tuple(
        PlannedRun(supports[index % len(supports)], motion) for index, motion in enumerate(motions)
    )


def _test_supports(supports: Sequence[DoubleSupport]) -> list[DoubleSupport]:
    """Up to two that are for tests alone, neither of them of the least or the greatest yaw."""
    if len(supports) <= _TRAIN_SUPPORTS:
        return []
    inner = sorted(supports, key=lambda support: support.dtheta)[1:-1:2]
    return [inner[0], inner[-1]][: len(supports) - _TRAIN_SUPPORTS]


def _require(supports: Sequence[DoubleSupport]) -> None:
    if not supports:
        raise ShoecalError("no double supports are given; give at least one")
