"""Sets of motions by name: which motion in which double support, to train or to test."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

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
    test: tuple[str, ...]

    def __len__(self) -> int:
        return len(self.train) + len(self.test)

    @property
    def runs(self) -> tuple[tuple[str, str], ...]:
        """Motion and hint of each run."""
        trained = tuple((motion, TRAIN) for motion in self.train)
        return (*trained, *((motion, TEST) for motion in self.test))


STANDARD, THOROUGH = "standard", "thorough"
MOTION_SETS: Mapping[str, MotionSet] = {
    # A minute of motion: as accurate as the thorough set's two within 0.05 mm. Unloading in another
    # double support than the neutral one costs 0.1 mm. Nothing that it tests, slowly and with a
    # tilted torso, is trained.
    STANDARD: MotionSet(
        "for a calibration: round the landmarks 1.8 times as fast, each foot lifted once",
        ("faster", "faster_reversed", "unload_left", "unload_right"),
        ("landmarks", "reversed", "torso_tilt"),
    ),
    # Effects of joints and links show by direction and height; a calibration needs neither.
    THOROUGH: MotionSet(
        "for a diagnosis: both directions, two heights of the torso, each foot lifted once",
        ("landmarks", "reversed", "torso_height", "unload_left", "unload_right"),
        ("landmarks", "reversed"),
    ),
}
"""By name. Each tests where nothing was trained."""

STANDARD_SUPPORTS = 5
"""Double supports of a set, each for one run but that of unloading."""


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

    Runs to train begin and end the range of yaw between the feet, and a run to test stands where no
    other does, in between. Where the double supports are too few for that, tests share those of the
    training, with other motions. Each foot is unloaded in the neutral support: there any robot can
    stand on one foot that can do so at all, and its motors and joints give least.

    Args:
        name: in MOTION_SETS.
        supports: double supports that differ in yaw; STANDARD_SUPPORTS of them are best.
        neutral: as in normal standing.

    Raises:
        ShoecalError: for no supports.
    """
    _require(supports)
    one = MOTION_SETS[name]
    by_yaw = sorted(supports, key=lambda support: support.dtheta)
    room = len(supports) - sum(motion not in UNLOADING for motion in one.train)
    tested = _spread(by_yaw[1:-1], min(len(one.test), room))
    # The ends of the range first: there may be more double supports than motions.
    ends = (by_yaw[0], by_yaw[-1])
    trained = [support for support in supports if support not in tested]
    trained.sort(key=lambda support: support not in ends)
    # Where both share them, tests move on by one, so that each meets another motion's support.
    places = {
        TRAIN: itertools.cycle(trained),
        TEST: itertools.cycle(tested or [*trained[1:], trained[0]]),
    }
    return tuple(
        PlannedRun(neutral if motion in UNLOADING else next(places[hint]), motion, hint)
        for motion, hint in one.runs
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


def _spread(inner: Sequence[DoubleSupport], count: int) -> list[DoubleSupport]:
    """As many of them, evenly from first to last."""
    at = np.linspace(0, len(inner) - 1, max(count, 0)).round().astype(int)
    return [inner[index] for index in at]


def _require(supports: Sequence[DoubleSupport]) -> None:
    if not supports:
        raise ShoecalError("no double supports are given; give at least one")
