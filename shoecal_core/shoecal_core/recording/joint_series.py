"""Angles of single joints over time, and what is wrong with them: no numbers, jumps to zero, angles
beyond the joints' limits.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.robot.robot import JointsMissingError, Robot

JUMP_RAD = 0.1
"""Angles that are exactly zero between two that are farther off are no motion."""
STEP_S = 0.2
"""Samples farther apart in time may move by that much."""
FAST_RAD_S = 5.0
"""The same at the start and the end, where only one neighbour shows it, if it is faster too."""
SEVERAL = 2
"""Joints that jump to zero at once, from which the whole message is at fault."""
RETURN_SHARE = 0.5
"""Of its angle, by which a joint may have moved while it read zero."""
MOST_NAMED = 6
BEYOND_RAD = 0.1
"""A joint whose zero is a little off misses its limits by less."""
FAR_RAD = 1.0
"""No joint is so far beyond its limits: its angles have another unit."""
TURNS_RAD = 2.0 * math.tau
"""The same of joints without an end: they may have turned round, but hardly twice."""


@dataclass(frozen=True)
class JointSeries:
    """One joint.

    Attributes:
        time: (k,) ascending [s].
        angle: (k,) NaN where there is no number [rad].
    """

    time: FloatArray
    angle: FloatArray

    def only(self, kept: BoolArray) -> JointSeries:
        """The samples of a mask (k,)."""
        return JointSeries(self.time[kept], self.angle[kept])


Series = Mapping[str, JointSeries]
"""By joint."""


def from_pieces(
    pieces: Mapping[str, Sequence[tuple[FloatArray, FloatArray]]],
) -> dict[str, JointSeries]:
    """Series of times (k,) [s] and angles (k,) [rad] in any order, by joint."""
    found = {}
    for name, parts in pieces.items():
        time, angle = (np.concatenate([part[which] for part in parts]) for which in (0, 1))
        order = np.argsort(time, kind="stable")
        found[name] = JointSeries(time[order], angle[order])
    return found


def with_numbers(
    series: Series, optional: Collection[str]
) -> tuple[dict[str, JointSeries], list[str]]:
    """The samples that are numbers, and a line for each group of joints that lacks some.

    Args:
        series: by joint.
        optional: joints that may be without any number: that is not noted.
    """
    good = {name: np.isfinite(one.angle) for name, one in series.items()}
    lacking = {
        name: (int((~mask).sum()), len(mask))
        for name, mask in good.items()
        if mask.any() or name not in optional
    }
    return {name: one.only(good[name]) for name, one in series.items()}, lacking_notes(lacking)


def lacking_notes(lacking: Mapping[str, tuple[int, int]]) -> list[str]:
    """A line for each group of joints without angles.

    Args:
        lacking: by joint, in how many messages it has no angle, and how many name it.
    """
    groups: dict[tuple[int, int], list[str]] = defaultdict(list)
    for name, counts in lacking.items():
        if counts[0]:
            groups[counts].append(name)
    return [
        f"{named(names)} {'has' if len(names) == 1 else 'have'} no angle (NaN) in {count} of "
        f"{total} messages"
        for (count, total), names in groups.items()
    ]


def without_zeros(series: Series) -> tuple[dict[str, JointSeries], list[str]]:
    """The samples that are no jump to zero, and a line for each group of joints that jumps.

    Args:
        series: by joint, numbers only.
    """
    zeros = jumps_to_zero(series)
    return {name: one.only(~zeros[name]) for name, one in series.items()}, zero_notes(series, zeros)


def zero_notes(series: Series, zeros: Mapping[str, BoolArray]) -> list[str]:
    """A line for each group of joints that jump to zero.

    Args:
        series: by joint, numbers only.
        zeros: (k,) of each joint, as `jumps_to_zero` finds them.
    """
    groups: dict[tuple[int, int, float], list[str]] = defaultdict(list)
    for name, mask in zeros.items():
        if mask.any():
            time = series[name].time
            first = round(float(time[int(np.argmax(mask))] - time[0]), 1)
            groups[int(mask.sum()), len(mask), first].append(name)
    return [
        f"{named(names)} {'jumps' if len(names) == 1 else 'jump'} to zero in {count} of {total} "
        f"messages, first {first:.1f} s after the first message, which are left out: check "
        "encoders and bus"
        for (count, total, first), names in groups.items()
    ]


def jumps_to_zero(series: Series) -> dict[str, BoolArray]:
    """(k,) of each joint: angles that are exactly zero for a moment while it is elsewhere.

    A joint that is near zero anyhow is taken to fail with the others of its message.

    Args:
        series: by joint, numbers only.
    """
    found = {name: _jumps_to_zero(one) for name, one in series.items()}
    failed = [one.time[found[name]] for name, one in series.items() if found[name].any()]
    if len(failed) < SEVERAL:
        return found
    times, count = np.unique(np.concatenate(failed), return_counts=True)
    together = times[count >= SEVERAL]
    for name, one in series.items():
        if (one.angle != 0.0).any():
            found[name] |= (one.angle == 0.0) & np.isin(one.time, together)
    return found


def _jumps_to_zero(series: JointSeries) -> BoolArray:
    """(k,) samples that are exactly zero while the joint, just before and after, is elsewhere.

    Args:
        series: numbers only.
    """
    time, angle = series.time, series.angle
    found: BoolArray = angle == 0.0
    if not found.any() or found.all():
        return np.zeros(len(angle), dtype=bool)
    edges = np.flatnonzero(np.diff(np.concatenate(([False], found, [False])).astype(np.int8)))
    for start, end in edges.reshape(-1, 2).tolist():
        sides = [
            (float(angle[outer]), float(abs(time[outer] - time[inner])))
            for outer, inner in ((start - 1, start), (end, end - 1))
            if 0 <= outer < len(angle)
        ]
        if not _jumped(sides):
            found[start:end] = False
    return found


def _jumped(sides: Sequence[tuple[float, float]]) -> bool:
    """Whether samples that are zero are a jump, by angle [rad] and step [s] to either side."""
    if not all(abs(angle) > JUMP_RAD and step <= STEP_S for angle, step in sides):
        return False
    if len(sides) == 1:
        angle, step = sides[0]
        return abs(angle) > FAST_RAD_S * step
    before, after = sides[0][0], sides[1][0]
    return abs(after - before) <= RETURN_SHARE * abs(before)


def named(names: Sequence[str]) -> str:
    """`joint 'a'`, `joints 'a', 'b' and 3 more`."""
    listed = ", ".join(f"'{name}'" for name in names[:MOST_NAMED])
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return f"{'joint' if len(names) == 1 else 'joints'} {listed}{more}"


def postures(series: Series, robot: Robot, count: int) -> tuple[FloatArray, FloatArray]:
    """Times (T,) [s] and angles of all joints (T, m) [rad] at `count` instants, evenly.

    Joints that no foot hangs on are taken at the robot's posture where they have no angle.

    Raises:
        JointsMissingError: for a joint between the feet without angles.
    """
    known = {
        name: one for name, one in series.items() if name in robot.joint_names and len(one.time)
    }
    legs = {robot.joint_names[joint] for joint in robot.between_feet}
    needed = [one for name, one in known.items() if name in legs]
    if not needed:
        raise JointsMissingError(robot.name, sorted(legs), list(known))
    first, last = max(one.time[0] for one in needed), min(one.time[-1] for one in needed)
    instants = np.linspace(first, max(first, last), count)
    lacking = [
        joint
        for joint, name in enumerate(robot.joint_names)
        if name not in known and name not in legs
    ]
    names = [*known, *(robot.joint_names[joint] for joint in lacking)]
    columns = [np.interp(instants, one.time, one.angle) for one in known.values()]
    columns += [np.full(count, robot.posture[joint]) for joint in lacking]
    return instants, robot.from_measured(names, np.stack(columns, axis=1))


def beyond_limits(joint: str, position: FloatArray, low: float, high: float) -> str:
    """What is beyond a joint's limits, in words; empty where nothing is.

    Args:
        joint: its name.
        position: (T,) one or more angles [rad].
        low, high: limits [rad].
    """
    beyond = _beyond(position, low, high)
    if beyond.max() <= BEYOND_RAD:
        return ""
    return (
        f"joint '{joint}' is at {position[np.argmax(beyond)]:.4g} rad, beyond its limits "
        f"{low:.4g} to {high:.4g} rad in the URDF"
    )


def in_degrees(position: FloatArray, low: float, high: float) -> bool:
    """Whether angles (T,) are far beyond limits [rad] that they are within as degrees.

    Those within them with the other sign are not: a joint's sign may be turned.
    """
    far = FAR_RAD if high - low < math.tau else TURNS_RAD
    return bool(
        _beyond(position, low, high).max() > far
        and _beyond(-position, low, high).max() > BEYOND_RAD
        and (_beyond(np.radians(position), low, high) < BEYOND_RAD).all()
    )


def _beyond(position: FloatArray, low: float, high: float) -> FloatArray:
    """How far angles (T,) are beyond limits; negative within."""
    return np.fmax(low - position, position - high)
