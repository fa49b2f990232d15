"""A joint's zero that moves while a session is recorded: a magnet, grub screw or horn is loose.

While both feet stand, the pose of one sole seen from the other keeps its place within a run, and
in all runs its height, roll and pitch are those of one floor. A zero that creeps, or jumps, shows
in that pose joint by joint. What else does so is fitted with it: constant zeros and scales of all
joints, gears that give as the body moves to and fro, another place of the foot and a little of the
floor in each run. Feet that move within a run are asked, too, whether they explain it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.recording.run import Run
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.lifting import UNLOADING
from shoecal_core.screening.blocks import one_after_another
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.vertical import both_carry_load

SAMPLES, LEAST_SAMPLES = 60, 30
"""Of each run, evenly over it; a run with fewer is not looked at."""
LEAST_RUNS = 2
"""From which a course over the session shows."""
UNIT_M, UNIT_RAD = 0.00025, 0.001
"""What sound robots leave of each number of the pose (0.8 to 1.1 of it): play, steps, sag."""
INDEPENDENT = 10
"""Samples of a run that count: neighbours are alike."""
STEP_RAD = 0.001
"""Of derivatives."""
FLOOR = 4.0
"""Standard deviation, in units, of height and tilts of the floor in one run."""
ZERO_RAD, SCALE, GIVE_RAD = 0.03, 0.03, 0.005
"""Standard deviations of a joint's constant zero, of its scale, and of how far its gear gives."""
FREE = 1e4
"""Standard deviation of what may be anything, in its unit."""
PIECES = 4
"""Of a run, in each of which the feet may stand elsewhere."""
LEAST_RAD = 0.008
"""A zero that moves less harms less than the tolerance of zeros."""
LEFT = 0.3
"""Of the sum of squares, what a moving zero leaves at most. Sound sessions keep 0.93 and more."""
SOUND, LEFT_OF_LITTLE = 2.0, 0.65
"""Where no more is left than this mean square, as in sound sessions, it may be so large a part of
the whole; courses that change within runs alone, for floors differ from run to run."""
LEAST_GAIN = 0.3
"""Of mean square that a moving zero explains, at least: 0.13 in sound sessions, 0.17 in two
of their runs."""
AS_GOOD = 0.12
"""Of what the best joint explains, that another one may explain less and be named, too."""
FEET_WORSE = 0.2
"""Of mean square, that feet that move leave more at least: where they slip or stand on an edge they
leave no more, and a hip's jump of 30 mrad within a run leaves 0.5 less than they do."""
MOST_NAMED = 3


@dataclass(frozen=True)
class LooseEncoder:
    """A joint whose zero moves.

    Attributes:
        joints: its name, and others that explain it as well.
        zeros: (first, last) by run, by how much the angles read more than at the start [rad].
        jump: run and time [s] in it at which it jumps once; None where it does not, or between
            two runs.
    """

    joints: tuple[str, ...]
    zeros: Mapping[int, tuple[float, float]] = field(default_factory=dict)
    jump: tuple[int, float] | None = None


@dataclass(frozen=True)
class _Standing:
    """T samples at which both feet stand: joint angles (T, m), run of each (T,), its time in the
    run (T,) and in the session (T,) [s].
    """

    angles: FloatArray
    run: FloatArray
    time: FloatArray
    since: FloatArray

    @property
    def runs(self) -> list[int]:
        """Their numbers."""
        return [int(run) for run in np.unique(self.run)]

    def pose(self, kinematics: Kinematics, angles: FloatArray | None = None) -> FloatArray:
        """(T, 6) of the right sole seen from the left, in units."""
        states = kinematics.states(self.angles if angles is None else angles)
        pose = states.right_sole
        pose[:, 5] = np.unwrap(pose[:, 5])
        return np.asarray(pose / ([UNIT_M] * 3 + [UNIT_RAD] * 3))

    def slopes(self, kinematics: Kinematics) -> dict[int, FloatArray]:
        """(T, 6) units per rad of each joint between the feet."""
        found = {}
        for joint in kinematics.robot.between_feet:
            step = STEP_RAD * np.eye(self.angles.shape[1])[joint]
            more, less = (self.pose(kinematics, self.angles + one) for one in (step, -step))
            found[joint] = np.asarray((more - less) / (2.0 * STEP_RAD))
        return found


@dataclass(frozen=True)
class _Course:
    """How a zero may move: columns (T, k), each in rad per size; whether only from run to run; the
    first sample after one jump, -1 without.
    """

    columns: FloatArray
    between: bool
    jump: int = -1


class _Misfit:
    """What is left of the pose once all that is usual is fitted."""

    def __init__(
        self, kinematics: Kinematics, standing: _Standing, slopes: Mapping[int, FloatArray]
    ) -> None:
        self._weight = float(np.sqrt(INDEPENDENT / SAMPLES))
        pose = standing.pose(kinematics)
        rows, stds = _usual(kinematics, standing, slopes)
        self._padding = len(stds)
        base = np.vstack((rows * self._weight, np.diag(1.0 / stds)))
        self._base = np.linalg.qr(base)[0]
        self.numbers = pose.size * self._weight**2
        self._off = self._without(pose.reshape(-1, 1))[:, 0]
        self.whole = self._square(self._off)

    def _square(self, values: FloatArray) -> float:
        return float(values @ values) / self.numbers

    def _without(self, columns: FloatArray) -> FloatArray:
        """(6T + u, k) columns (6T, k), weighted, without what is usual."""
        padded = np.vstack((columns * self._weight, np.zeros((self._padding, columns.shape[1]))))
        return np.asarray(padded - self._base @ (self._base.T @ padded))

    def left_by_all(self, columns: FloatArray) -> tuple[float, FloatArray]:
        """Mean square that columns (6T, k) leave together, and their sizes (k,).

        Each but the first adds what it takes away by chance.
        """
        rows = self._without(columns)
        sizes = np.linalg.lstsq(rows, self._off, rcond=1e-6)[0]
        chance = (len(sizes) - 1) / self.numbers
        return self._square(self._off - rows @ sizes) + chance, np.asarray(sizes, dtype=np.float64)

    def left_by_each(self, columns: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(k,) what each of columns (6T, k) leaves alone, and its size (k,)."""
        rows = self._without(columns)
        square = np.maximum(np.einsum("ij,ij->j", rows, rows), 1e-12)
        along = rows.T @ self._off
        return self.whole - along**2 / square / self.numbers, along / square


def loose_encoder(
    runs: Mapping[int, Run], aligned: Mapping[int, Aligned], shoe: Shoe, kinematics: Kinematics
) -> LooseEncoder | None:
    """The joint whose moving zero explains most of how soles move that should not, if any."""
    standing = _standing(runs, aligned, shoe)
    if standing is None:
        return None
    slopes = standing.slopes(kinematics)
    misfit = _Misfit(kinematics, standing, slopes)
    if misfit.whole < LEAST_GAIN:
        return None
    found = sorted(
        (
            (*_best(misfit, standing, slope), name)
            for name, slope in _encoders(kinematics.robot, slopes)
        ),
        key=lambda one: one[0],
    )
    left, course, zero, _ = found[0]
    gain = misfit.whole - left
    share = left / misfit.whole
    little = not course.between and left < SOUND and share < LEFT_OF_LITTLE
    if gain < LEAST_GAIN or not (share < LEFT or little) or np.ptp(zero) < LEAST_RAD:
        return None
    if misfit.left_by_all(_feet(standing, course.jump))[0] < left + FEET_WORSE:
        return None
    names = tuple(name for other, _, _, name in found if other < left + AS_GOOD * gain)
    if len(names) > MOST_NAMED:
        return None
    zeros = {
        run: (float(zero[here[0]]), float(zero[here[-1]]))
        for run in standing.runs
        for here in [np.flatnonzero(standing.run == run)]
    }
    jump = None
    if course.jump > 0 and not course.between:
        jump = int(standing.run[course.jump]), float(standing.time[course.jump])
    return LooseEncoder(names, zeros, jump)


def _standing(
    runs: Mapping[int, Run], aligned: Mapping[int, Aligned], shoe: Shoe
) -> _Standing | None:
    """Samples of runs in double support that lift no foot on purpose."""
    kept = dict[int, tuple[Aligned, IntArray]]()
    for number, run in sorted(runs.items()):
        one = aligned.get(number)
        if one is None or run.info.support is None or run.info.motion in UNLOADING:
            continue
        both = both_carry_load(shoe, one.readings)
        at = np.arange(len(one.time)) if both is None else np.flatnonzero(both)
        if run.info.hanging or len(at) < LEAST_SAMPLES:
            continue
        kept[number] = one, at[np.unique(np.linspace(0, len(at) - 1, SAMPLES).astype(np.int64))]
    if len(kept) < LEAST_RUNS:
        return None
    starts = one_after_another(
        [runs[number].start_ns / 1e9 for number in kept],
        [float(one.time[-1]) for one, _ in kept.values()],
    )
    parts = [
        (one.joint_angles[at], np.full(len(at), float(number)), one.time[at], start + one.time[at])
        for (number, (one, at)), start in zip(kept.items(), starts, strict=True)
    ]
    return _Standing(*(np.concatenate(one) for one in zip(*parts, strict=True)))


def _usual(
    kinematics: Kinematics, standing: _Standing, slopes: Mapping[int, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """(6T, u) what the pose of a sound robot may have, and the standard deviation of each (u,).

    By slopes (T, 6) of the joints.
    """
    columns, stds = list[FloatArray](), list[float]()
    for run in standing.runs:
        here = (standing.run == run).astype(np.float64)
        for axis in range(6):
            columns.append(np.outer(here, np.eye(6)[axis]))
            stds.append(FREE if axis in (0, 1, 5) else FLOOR)
    com = kinematics.states(standing.angles).com[:, 0, :2]
    sway = (com - com.mean(axis=0)) / np.maximum(com.std(axis=0), 1e-6)
    for joint, slope in slopes.items():
        turned = standing.angles[:, joint] - standing.angles[:, joint].mean()
        shapes = (np.ones(len(slope)), turned, *sway.T)
        columns += [slope * shape[:, None] for shape in shapes]
        stds += [ZERO_RAD, SCALE, GIVE_RAD, GIVE_RAD]
    return np.stack([one.ravel() for one in columns], axis=1), np.array(stds)


def _encoders(robot: Robot, slopes: Mapping[int, FloatArray]) -> Iterator[tuple[str, FloatArray]]:
    """The name of each encoder between the feet, and the slope (T, 6) of all joints it reads."""
    led = {one.joint for one in robot.shared}
    for joint in sorted(slopes.keys() - led):
        ratios = {one.joint: one.ratio for one in robot.shared if one.leader == joint}
        parts = [ratio * slopes[one] for one, ratio in ratios.items() if one in slopes]
        yield robot.joint_names[joint], np.sum([slopes[joint], *parts], axis=0)


def _best(
    misfit: _Misfit, standing: _Standing, slope: FloatArray
) -> tuple[float, _Course, FloatArray]:
    """What the best course of one joint's zero leaves, that course, and the zero (T,) beyond its
    first [rad]; its slope is (T, 6).
    """
    best = _best_jump(misfit, standing, slope)
    for course in _steady(standing):
        columns = (slope[:, :, None] * course.columns[:, None, :]).reshape(slope.size, -1)
        left, size = misfit.left_by_all(columns)
        if left < best[0]:
            best = left, course, course.columns @ size
    left, course, zero = best
    return left, course, np.asarray(zero - zero[0])


def _best_jump(
    misfit: _Misfit, standing: _Standing, slope: FloatArray
) -> tuple[float, _Course, FloatArray]:
    """What the best jump between two samples leaves, its course, and the zero (T,) [rad]."""
    count = len(standing.run)
    samples = np.arange(1, count)
    steps = (np.arange(count)[:, None] >= samples).astype(np.float64)
    lefts, sizes = misfit.left_by_each(
        (slope[:, :, None] * steps[:, None, :]).reshape(-1, len(samples))
    )
    best = int(np.argmin(lefts))
    at = best + 1
    between = bool(standing.run[at] != standing.run[at - 1])
    course = _Course(steps[:, best : best + 1], between, at)
    return float(lefts[best]), course, sizes[best] * steps[:, best]


def _steady(standing: _Standing) -> Iterator[_Course]:
    """It creeps, by the clock or while the robot moves; or is another one in each run."""
    count = len(standing.run)
    since = (standing.since - standing.since[0]) / max(np.ptp(standing.since), 1e-9)
    for ramp in (since, np.arange(count) / count):
        yield _Course(ramp[:, None], between=False)
    each = [(standing.run == run).astype(np.float64) for run in standing.runs[1:]]
    yield _Course(np.stack(each, axis=1), between=True)


def _feet(standing: _Standing, jump: int) -> FloatArray:
    """(6T, k) the right foot stands elsewhere in each piece of each run; from a jump within a run
    on, to its end, also higher and tilted.
    """
    count = len(standing.run)
    columns = []
    for run in standing.runs:
        for piece in np.array_split(np.flatnonzero(standing.run == run), PIECES)[1:]:
            inside: BoolArray = np.isin(np.arange(count), piece)
            columns += [np.outer(inside, np.eye(6)[axis]).ravel() for axis in (0, 1, 5)]
    if jump >= 0:
        after = (np.arange(count) >= jump) & (standing.run == standing.run[jump])
        columns += [np.outer(after, axis).ravel() for axis in np.eye(6)]
    return np.stack(columns, axis=1)


def describe_loose_encoder(found: LooseEncoder | None) -> list[Finding]:
    """The joint, and how its zero moves."""
    if found is None:
        return []
    first, last = min(found.zeros), max(found.zeros)
    at_end = 1e3 * found.zeros[last][1]
    if found.jump is not None:
        run, time = found.jump
        moves = f"jumps by {abs(at_end):.0f} mrad in run {run} (at {time:.1f} s)"
    elif all(one == other for one, other in found.zeros.values()):
        listed = ", ".join(f"{1e3 * one:.0f}" for one, _ in found.zeros.values())
        moves = f"moves from run to run ({listed} mrad in runs {_listed(list(found.zeros))})"
    else:
        moves = f"moves, from 0 in run {first} to {at_end:.0f} mrad in run {last}"
    joint, *others = found.joints
    or_other = f" (or of {' or '.join(others)})" if others else ""
    return [
        Finding(
            "FAIL",
            f"by feet that stay in place the zero of {joint}{or_other} {moves}: its magnet, grub "
            "screw or horn is loose; tighten it, zero it, and record again",
            Fault.JOINT_ZERO,
        )
    ]


def _listed(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers))
