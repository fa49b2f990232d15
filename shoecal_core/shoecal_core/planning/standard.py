"""The standard set of motions: which motion in which double support, what for."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

from shoecal_core.errors import ShoecalError
from shoecal_core.planning.motion_catalogue import motion_kind
from shoecal_core.robot.double_support import DoubleSupport

TRAIN, TEST = "train", "test"
UNLOADING = ("unload_left", "unload_right")
"""Motions that lift a foot."""


@dataclass(frozen=True)
class StandardMotion:
    """One run of the standard set.

    Attributes:
        motion: name in the motion catalogue.
        hint: whether the run is meant to train or to test.
    """

    motion: str
    hint: str


STANDARD = (
    StandardMotion("landmarks", TRAIN),
    StandardMotion("reversed", TRAIN),
    StandardMotion("torso_height", TRAIN),
    StandardMotion("unload_left", TRAIN),
    StandardMotion("unload_right", TRAIN),
    StandardMotion("landmarks", TEST),
    StandardMotion("reversed", TEST),
)
"""Of a calibration and of a diagnosis: both directions, two heights of the torso, and each foot
without load once. Fast motions jolt the robot and teach gains nothing."""

STANDARD_SUPPORTS = 5
"""Double supports of the standard set: three to train in, two to test in."""
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


def standard_runs(
    supports: Sequence[DoubleSupport], neutral: DoubleSupport
) -> tuple[PlannedRun, ...]:
    """The standard set in double supports, as it is recorded.

    Training and testing take turns from yaw to yaw: runs to train begin and end the range of yaw
    between the feet, and a run to test stands where no other does, in between. Fewer than four
    double supports leave none for tests alone: those are then shared, with other motions. Each foot
    is unloaded in the neutral support: there any robot can stand on one foot that can do so at all.

    Args:
        supports: double supports that differ in yaw; STANDARD_SUPPORTS of them are best.
        neutral: as in normal standing.

    Raises:
        ShoecalError: for no supports.
    """
    _require(supports)
    tested = _test_supports(supports)
    trained = [support for support in supports if support not in tested]
    # Where both share them, tests move on by one, so that each meets another motion's support.
    places = {
        TRAIN: itertools.cycle(trained),
        TEST: itertools.cycle(tested or [*trained[1:], trained[0]]),
    }
    return tuple(
        PlannedRun(
            neutral if one.motion in UNLOADING else next(places[one.hint]), one.motion, one.hint
        )
        for one in STANDARD
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
