"""A joint that is far off, found by the soles of feet that stand on one floor.

While both feet stand, the soles are level with each other and do not move against each other. A
constant error of one joint between them tilts and lifts one sole, and makes it wander when the
robot moves. The joint whose correction closes that loop is the one that is off; two joints may do
so equally well, as both knees do where both legs bend alike. A turned sign, two joints at each
other's place and an encoder that fails close it as well, with no constant.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from itertools import combinations

import numpy as np
from scipy.optimize import minimize_scalar

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.kinematics import BodyStates, Kinematics
from shoecal_core.robot.robot import Robot

CLOSED_M, CLOSED_RAD = 0.01, float(np.radians(2.0))
"""Soles of a robot whose zeros are right are level to within this: play and sag of its joints."""
OPEN_M, OPEN_RAD = 2.0 * CLOSED_M, 2.0 * CLOSED_RAD
"""A gap or tilt that play, sag and small errors of zeros do not make; a calibration copes with
less."""
WANDER_M = 0.01
"""Feet of a run in double support that move further against each other are refused."""
LEVEL_SHARE = 0.15
"""Of samples at which the soles are level, from which zeros are not blamed: the rest are steps."""
CLOSES_SHARE = 0.5
"""Of samples that a correction has to close."""
ALL_SHARE = 0.8
"""The same where the soles are level as recorded, and only wander: feet that step do so, too."""
BETTER = 0.5
"""Of the misfit as recorded, what a correction may leave."""
AS_GOOD, ALIKE = 1.5, 0.05
"""Joints whose correction leaves so many times the least misfit, and this, explain the soles as
well."""
SAME_RAD = 0.1
"""Zeros that runs find of one joint are as far apart, at most."""
MOST_NAMED = 3
SAMPLES = 80
"""Samples that are looked at, evenly over all."""
REACH_RAD, STEP_RAD, LEAST_RAD = 1.4, 0.1, 2.0 * CLOSED_RAD
"""Errors that are looked for, the steps of the search, and the least one that is named."""
CONSTANT_RAD, FINE_RAD = 1e-6, 0.02
"""An encoder that fails changes by less; its joint's true angle is looked for in such steps."""


class Law(Enum):
    """What one joint, or two, may be but a constant error: in words, and what to do."""

    SIGN = ("a joint's sign is turned (best fit: {} with the other sign)", "correct the sign")
    EXCHANGED = (
        "two joints are exchanged (best fit: {} at each other's place)",
        "exchange their names or cables",
    )
    FROZEN = (
        "an encoder fails (best fit: {} moves, and its recorded angle does not)",
        "see to its encoder",
    )


@dataclass(frozen=True)
class OpenLoop:
    """Soles that are not level with each other, by the joint angles.

    Attributes:
        height: of one sole above the other, median [m].
        tilt: between them, median [rad].
        wander: how far one sole moves against the other [m].
        fits: joints and what is to be added to their angles [rad], the best first, each of which
            closes the loop alone; none where no single one does.
        law: what closes it better than any zero does; None where nothing does.
        names: joints that do so by that law, the best first; of two, joined by `and`.
    """

    height: float
    tilt: float
    wander: float
    fits: tuple[tuple[str, float], ...]
    law: Law | None = None
    names: tuple[str, ...] = ()

    def named(self, *, loaded: bool) -> bool:
        """Whether a joint explains it.

        Args:
            loaded: both feet are known to carry load; else a leg that swings about one joint looks
                as if the encoder of another one stood still.
        """
        return bool(self.fits or (self.names and (loaded or self.law is not Law.FROZEN)))

    def with_another(self, other: OpenLoop) -> OpenLoop | None:
        """Both as one, with the joints that explain both, larger gaps first; None where no joint
        does, or one explains only one of them.
        """
        theirs = dict(other.fits)
        names = tuple(name for name in self.names if name in other.names)
        fits = tuple(
            (name, 0.5 * (size + theirs[name]))
            for name, size in self.fits
            if abs(size - theirs.get(name, np.inf)) < SAME_RAD
        )
        if self.law is not other.law or bool(names) != bool(self.law):
            return None
        if self.law is None and bool(fits) != bool(self.fits or other.fits):
            return None
        height, tilt, wander = (
            max(getattr(one, name) for one in (self, other))
            for name in ("height", "tilt", "wander")
        )
        return OpenLoop(height, tilt, wander, fits, self.law, names)

    def text(self, *, loaded: bool) -> str:
        """What is seen, and the joint that explains it.

        Args:
            loaded: both feet are known to carry load; else that is left to the reader.
        """
        while_ = " while both carry load" if loaded else ""
        so = "" if loaded else "if both feet stand, "
        seen = (
            f"the soles are {1e3 * self.height:.0f} mm apart in height and tilted by "
            f"{np.degrees(self.tilt):.0f} degrees against each other{while_}: {so}"
            if self.height > OPEN_M or self.tilt > OPEN_RAD
            else f"the soles move by {1e3 * self.wander:.0f} mm against each other{while_}: {so}"
        )
        if self.law is not None:
            names, (what, cure) = " or ".join(self.names), self.law.value
            return f"with {names} as recorded {seen}{what.format(names)}; {cure} and record again"
        if not self.fits:
            return (
                f"by the joint angles {seen}a joint's zero or sign, or a sole's frame in the robot "
                "file, is off, and no single joint's zero explains it: check them"
            )
        names = " or ".join(name for name, _ in self.fits)
        best = " or ".join(f"{name} by {size:+.2f} rad" for name, size in self.fits)
        return (
            f"with {names} as recorded {seen}a joint's zero is off (best fit: {best}); correct "
            "the zero and record again"
        )


def open_loop(kinematics: Kinematics, angles: FloatArray) -> OpenLoop | None:
    """The soles' gap and tilt, and the joints whose constant error explains them.

    Args:
        kinematics: of the robot.
        angles: (T, m) finite, of instants at which both feet mostly stand [rad].

    Returns:
        None where the soles are level at some share of the instants, or there are none; unless they
        wander, and the error of one joint explains all of that.
    """
    if not len(angles):
        return None
    chosen = np.unique(np.linspace(0, len(angles) - 1, SAMPLES).astype(np.int64))
    angles = angles[chosen]
    states = kinematics.states(angles)
    height, tilt = _off_level(states)
    share = float(np.mean((height <= OPEN_M) & (tilt <= OPEN_RAD)))
    level = share >= LEVEL_SHARE
    low, high = np.percentile(states.translation[:, :2], [5.0, 95.0], axis=0)
    wander = float((high - low).max())
    constant = _constant(kinematics.robot, angles) if share < ALL_SHARE else []
    if level and wander <= WANDER_M and not constant:
        return None
    found = []
    for group in _motors(kinematics.robot):
        error = _Error(kinematics, angles, group)
        size = error.best()
        misfit = error.misfit(size)
        if abs(size) < LEAST_RAD or misfit > BETTER * error.misfit(0.0):
            continue
        if _closed(error.states(size), ALL_SHARE if level else CLOSES_SHARE):
            found.append((misfit, kinematics.robot.joint_names[group[0][0]], size))
    found.sort()
    fits: dict[str, float] = {}
    for misfit, name, size in found:
        if misfit <= AS_GOOD * found[0][0] + ALIKE:
            # A joint may be found alone and with its whole motor: the better one counts.
            fits.setdefault(name, size)
    law, names = _by_law(kinematics, angles, constant, found[0][0] if found else np.inf)
    if level and not (fits or names):
        return None
    best = tuple(fits.items())[:MOST_NAMED]
    return OpenLoop(float(np.median(height)), float(np.median(tilt)), wander, best, law, names)


def _by_law(
    kinematics: Kinematics, angles: FloatArray, constant: Sequence[int], least: float
) -> tuple[Law | None, tuple[str, ...]]:
    """The law that closes the loop and leaves less than a misfit, and by which joints, the best
    first.

    A sign that only makes up for a constant error is none: angles that hardly change have either.
    """
    recorded = _misfit(kinematics.states(angles))
    found = []
    for law, name, changed in _by_laws(kinematics, angles, constant):
        states = kinematics.states(changed)
        misfit = _misfit(states)
        if misfit < BETTER * min(least, recorded) and _closed(states, ALL_SHARE):
            found.append((misfit, law.name, name))
    if not found:
        return None, ()
    found.sort()
    best, law_name, _ = found[0]
    near = [
        name for misfit, own, name in found if own == law_name and misfit <= AS_GOOD * best + ALIKE
    ]
    return Law[law_name], tuple(dict.fromkeys(near))[:MOST_NAMED]


def _by_laws(
    kinematics: Kinematics, angles: FloatArray, constant: Sequence[int]
) -> Iterator[tuple[Law, str, FloatArray]]:
    """What may be, by which joints, and the angles (T, m) that then were [rad]."""
    robot = kinematics.robot
    names = robot.joint_names
    for group in _motors(robot):
        turned = angles.copy()
        turned[:, [joint for joint, _ in group]] *= -1.0
        yield Law.SIGN, names[group[0][0]], turned
    for one, other in combinations(robot.between_feet, 2):
        exchanged = angles.copy()
        exchanged[:, [one, other]] = angles[:, [other, one]]
        yield Law.EXCHANGED, f"{names[one]} and {names[other]}", exchanged
    for joint in constant:
        yield Law.FROZEN, names[joint], _moved(kinematics, angles, joint)


def _constant(robot: Robot, angles: FloatArray) -> list[int]:
    """Joints between the feet whose angles (T, m) never change while others do."""
    between = list(robot.between_feet)
    moved = np.ptp(angles[:, between], axis=0)
    if moved.max(initial=0.0) < LEAST_RAD:
        return []
    return [joint for joint, own in zip(between, moved, strict=True) if own < CONSTANT_RAD]


def _moved(kinematics: Kinematics, angles: FloatArray, joint: int) -> FloatArray:
    """(T, m) angles with those of one joint that bring the soles nearest to level, each instant."""
    sizes = np.arange(-REACH_RAD, REACH_RAD + 0.5 * FINE_RAD, FINE_RAD)
    several = np.repeat(angles[:, None], len(sizes), axis=1)
    several[:, :, joint] += sizes
    height, tilt = _off_level(kinematics.states(several.reshape(-1, angles.shape[1])))
    off = (height / CLOSED_M) ** 2 + (tilt / CLOSED_RAD) ** 2
    moved = angles.copy()
    moved[:, joint] += sizes[off.reshape(len(angles), -1).argmin(axis=1)]
    return moved


@dataclass(frozen=True)
class _Error:
    """One motor's constant error: joints by index, and how far each turns with it."""

    kinematics: Kinematics
    angles: FloatArray
    group: Sequence[tuple[int, float]]

    def states(self, size: float) -> BodyStates:
        """With a correction [rad]."""
        angles = self.angles.copy()
        for joint, ratio in self.group:
            angles[:, joint] += ratio * size
        return self.kinematics.states(angles)

    def misfit(self, size: float) -> float:
        """What it leaves."""
        return _misfit(self.states(size))

    def best(self) -> float:
        """The correction with the least misfit [rad]."""
        sizes = np.arange(-REACH_RAD, REACH_RAD + 0.5 * STEP_RAD, STEP_RAD)
        start = float(sizes[np.argmin([self.misfit(float(size)) for size in sizes])])
        bounds = (start - STEP_RAD, start + STEP_RAD)
        return float(minimize_scalar(self.misfit, bounds=bounds, method="bounded").x)


def _misfit(states: BodyStates) -> float:
    """Mean over all samples of how far the soles are from level and from standing still, in
    tolerances; those in which a foot is lifted count little.
    """
    return float(np.mean(np.log1p(np.sum(_residuals(states) ** 2, axis=1))))


def _closed(states: BodyStates, share: float) -> bool:
    """Whether the soles are level and still, at this share of the samples."""
    off = np.abs(_residuals(states))
    return bool(np.mean((off <= 1.0).all(axis=1)) >= share)


def _off_level(states: BodyStates) -> tuple[FloatArray, FloatArray]:
    """(T,) height of one sole above the other [m], (T,) tilt between them [rad]."""
    tilt = np.arccos(np.clip(states.rotation[:, 2, 2], -1.0, 1.0))
    return np.abs(states.translation[:, 2]), tilt


def _residuals(states: BodyStates) -> FloatArray:
    """(T, 5): height, tilt, and how far x, y and yaw are off their medians; in tolerances."""
    height, tilt = _off_level(states)
    place = states.translation[:, :2]
    turned = np.unwrap(states.yaw)
    columns = (height, *(place - np.median(place, axis=0)).T, tilt, turned - np.median(turned))
    sizes = (CLOSED_M, CLOSED_M, CLOSED_M, CLOSED_RAD, CLOSED_RAD)
    return np.stack(columns, axis=1) / sizes


def _motors(robot: Robot) -> list[list[tuple[int, float]]]:
    """What one error may turn on the way from one sole to the other: each motor's joints, by index,
    with their ratios; and joints on one motor also alone, as both may be measured.
    """
    follows = {one.joint: one.leader for one in robot.shared}
    leaders = sorted({follows.get(joint, joint) for joint in robot.between_feet})
    together = [
        [(leader, 1.0), *((one.joint, one.ratio) for one in robot.shared if one.leader == leader)]
        for leader in leaders
    ]
    shared = {joint for group in together if len(group) > 1 for joint, _ in group}
    return together + [[(joint, 1.0)] for joint in robot.between_feet if joint in shared]
