"""A joint that is far off, found by the soles of feet that stand on one floor.

While both feet stand, the soles are level with each other and do not move against each other. A
constant error of one joint between them tilts and lifts one sole, and makes it wander when the
robot moves. The joint whose correction closes that loop is the one that is off; two joints may do
so equally well, as both knees do where both legs bend alike. What closes it with no constant is in
`joint_laws.py`. Runs with one cause show more of it together: what looks alike where the feet stand
in one place differs where they stand in another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_laws import (
    ALIKE,
    ALL_SHARE,
    AS_GOOD,
    BETTER,
    MOST_NAMED,
    Law,
    by_law,
    constant_joints,
    motors,
)
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.level_soles import CLOSED_M, CLOSED_RAD, Postures, off_level, sampled

OPEN_M, OPEN_RAD = 2.0 * CLOSED_M, 2.0 * CLOSED_RAD
"""A gap or tilt that play, sag and small errors of zeros do not make; a calibration copes with
less."""
WANDER_M = 0.01
"""Feet of a run in double support that move further against each other are refused."""
LEVEL_SHARE = 0.15
"""Of samples at which the soles are level, from which zeros are not blamed: the rest are steps."""
CLOSES_SHARE = 0.5
"""Of samples that the correction of a zero has to close, where the soles are not level."""
SAME_RAD = 0.1
"""Zeros that runs find of one joint are as far apart, at most."""
REACH_RAD, STEP_RAD, LEAST_RAD = 1.4, 0.1, 2.0 * CLOSED_RAD
"""Errors that are looked for, the steps of the search, and the least one that is named."""


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
        factors: by which their angles are to be multiplied, where that is the law.
    """

    height: float
    tilt: float
    wander: float
    fits: tuple[tuple[str, float], ...]
    law: Law | None = None
    names: tuple[str, ...] = ()
    factors: tuple[float, ...] = ()

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
        own = dict(zip(self.names, self.factors, strict=False))
        factors = tuple(own[name] for name in names if name in own)
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
        return OpenLoop(height, tilt, wander, fits, self.law, names, factors)

    def by(self, cause: OpenLoop) -> OpenLoop:
        """The same soles, explained by what explains them and others."""
        return replace(
            self, fits=cause.fits, law=cause.law, names=cause.names, factors=cause.factors
        )

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
            scaled = zip(self.names, self.factors, strict=False)
            best = " or ".join(f"{name} times {factor:.3g}" for name, factor in scaled) or names
            return f"with {names} as recorded {seen}{what.format(best)}; {cure} and record again"
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


def open_loop(kinematics: Kinematics, *runs: FloatArray) -> OpenLoop | None:
    """The soles' gap and tilt, and the joints whose error explains them.

    Args:
        kinematics: of the robot.
        runs: (T, m) finite angles of instants at which both feet mostly stand [rad]; of several
            runs, what explains all of them.

    Returns:
        None where the soles are level at some share of the instants, or there are none; unless they
        wander, and the error of one joint explains all of that.
    """
    runs = tuple(one for one in runs if len(one))
    if not runs:
        return None
    postures = sampled(kinematics, runs)
    height, tilt = off_level(postures.states)
    share = float(np.mean((height <= OPEN_M) & (tilt <= OPEN_RAD)))
    level, wander = share >= LEVEL_SHARE, postures.wander()
    constant = constant_joints(kinematics.robot, postures.angles) if share < ALL_SHARE else []
    if level and wander <= WANDER_M and not constant:
        return None
    least, fits = _zeros(postures, ALL_SHARE if level else CLOSES_SHARE)
    by = by_law(postures, constant, least)
    if level and not (fits or by.names):
        return None
    gap, lean = float(np.median(height)), float(np.median(tilt))
    return OpenLoop(gap, lean, wander, fits, by.law, by.names, by.factors)


def _zeros(postures: Postures, share: float) -> tuple[float, tuple[tuple[str, float], ...]]:
    """The least misfit that the constant error of one joint leaves; and joints that leave as much,
    the best first, with what is to be added to their angles [rad].

    Args:
        postures: as recorded.
        share: of them that a correction has to close.
    """
    robot, found = postures.kinematics.robot, []
    for group in motors(robot):
        error = _Error(postures, group)
        size = error.best()
        corrected = error.corrected(size)
        if abs(size) < LEAST_RAD or corrected.misfit > BETTER * postures.misfit:
            continue
        if corrected.closed(share):
            found.append((corrected.misfit, robot.joint_names[group[0][0]], size))
    found.sort()
    fits: dict[str, float] = {}
    for misfit, name, size in found:
        if misfit <= AS_GOOD * found[0][0] + ALIKE:
            # A joint may be found alone and with its whole motor: the better one counts.
            fits.setdefault(name, size)
    return (found[0][0] if found else np.inf), tuple(fits.items())[:MOST_NAMED]


@dataclass(frozen=True)
class _Error:
    """One motor's constant error: joints by index, and how far each turns with it."""

    postures: Postures
    group: Sequence[tuple[int, float]]

    def corrected(self, size: float) -> Postures:
        """With a correction [rad]."""
        angles = self.postures.angles.copy()
        for joint, ratio in self.group:
            angles[:, joint] += ratio * size
        return self.postures.changed(angles)

    def misfit(self, size: float) -> float:
        """What it leaves."""
        return self.corrected(size).misfit

    def best(self) -> float:
        """The correction with the least misfit [rad]."""
        sizes = np.arange(-REACH_RAD, REACH_RAD + 0.5 * STEP_RAD, STEP_RAD)
        start = float(sizes[np.argmin([self.misfit(float(size)) for size in sizes])])
        bounds = (start - STEP_RAD, start + STEP_RAD)
        return float(minimize_scalar(self.misfit, bounds=bounds, method="bounded").x)
