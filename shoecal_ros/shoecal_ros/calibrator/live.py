"""Readings -> what controllers get: each foot's force and CoP, and both together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from shoecal_msgs.msg import ShoeVoltages

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.shoe.sensing import FootInstant, Place, Sensing
from shoecal_ros.calibrator.load import LEFT, RIGHT, LoadSwitch
from shoecal_ros.inputs.joining import Joined

Wrench = tuple[float, float, float]


@dataclass(frozen=True)
class Live:
    """Both feet at one instant.

    Attributes:
        stamp_ns: time of sampling [ns].
        feet: left, right; without a CoP where a foot carries no load.
        reported: of which feet there is something new.
        frame: foot in whose sole frame `wrench` and `cop` are.
        wrench: F [N], Mx, My [N m] of both feet; None where it is not known.
        cop: of both feet [m]; None where no foot carries load, or it is not known.
        loaded: which feet carry load.
        readings: (n,) raw, filtered; NaN where they are not good.
    """

    stamp_ns: int
    feet: tuple[FootInstant, FootInstant]
    reported: tuple[bool, bool]
    frame: int
    wrench: Wrench | None
    cop: Place | None
    loaded: tuple[bool, bool]
    readings: FloatArray


@dataclass(frozen=True)
class FootFlags:
    """What one foot's numbers are worth right now: see shoecal_msgs/msg/FootState."""

    loaded: bool
    valid: bool
    stale: bool
    extrapolating: bool
    status: tuple[int, ...]


@dataclass(frozen=True)
class Doubts:
    """About the calibration in force: see shoecal_msgs/msg/ShoeForces."""

    unconfirmed: bool
    disagrees: bool


class OutputFilter:
    """First-order low-pass of all channels; it delays them by `delay_s`."""

    def __init__(self, cutoff_hz: float) -> None:
        """No filter where the cut-off frequency is zero."""
        self.delay_s = 1.0 / (2.0 * math.pi * cutoff_hz) if cutoff_hz > 0.0 else 0.0
        self._state: FloatArray | None = None
        self._stamp_ns = 0

    def __call__(self, stamp_ns: int, readings: FloatArray) -> FloatArray:
        """Filtered readings (n,); what was not known or is not known starts again."""
        if not self.delay_s:
            return readings
        before, elapsed_s = self._state, (stamp_ns - self._stamp_ns) / 1e9
        self._stamp_ns = stamp_ns
        if before is None or elapsed_s < 0.0:
            self._state = readings
        else:
            share = 1.0 - math.exp(-elapsed_s / self.delay_s)
            smooth = before + share * (readings - before)
            self._state = np.where(np.isfinite(smooth), smooth, readings)
        return self._state


class LiveSensing:
    """Turns joined readings into what is published."""

    def __init__(
        self, of_foot: Sequence[IntArray], switch: LoadSwitch, low_pass: OutputFilter
    ) -> None:
        """Uncalibrated.

        Args:
            of_foot: indices of each foot's channels.
            switch: gives the loaded feet.
            low_pass: of the readings.
        """
        self.sensing: Sensing | None = None
        """Under the calibration in force; None while uncalibrated."""
        self._of_foot = of_foot
        self._switch = switch
        self._low_pass = low_pass
        self._status = np.full(sum(map(len, of_foot)), ShoeVoltages.NO_DATA, dtype=np.uint8)
        self._last: Live | None = None

    def take(self, joined: Sequence[Joined], support: DoubleSupport | None) -> list[Live]:
        """Take readings in order; nothing comes out while uncalibrated.

        Args:
            joined: readings.
            support: where the right foot stands, None where that is unknown.
        """
        if not joined:
            return []
        self._status = joined[-1].status
        if self.sensing is None:
            self._last = None
            return []
        turn = None if support is None else _Turn(support)
        lives = [self._live(one, self.sensing, turn) for one in joined]
        self._last = lives[-1]
        return lives

    def flags(
        self, stale: tuple[bool, bool], *, usable: bool = True
    ) -> tuple[FootFlags, FootFlags]:
        """Condition of both feet, left and right.

        Args:
            stale: which of them has no fresh readings.
            usable: whether the robot's weight bears the calibration out.
        """
        left, right = (self._flags(foot, stale[foot], usable) for foot in (LEFT, RIGHT))
        return left, right

    def _flags(self, foot: int, stale: bool, usable: bool) -> FootFlags:
        status = self._status[self._of_foot[foot]]
        known = usable and self._last is not None and not stale
        own = None if self._last is None else self._last.feet[foot]
        return FootFlags(
            loaded=self._last is not None and self._last.loaded[foot],
            valid=known and own is not None and not math.isnan(own.force),
            stale=stale,
            extrapolating=own is not None and own.extrapolating,
            status=tuple(status.tolist()),
        )

    def _live(self, one: Joined, sensing: Sensing, turn: _Turn | None) -> Live:
        readings = one.readings
        if one.status.any():
            # A reading that is not good is none: a wrong number is worse than no number.
            readings = np.where(one.status == ShoeVoltages.GOOD, readings, np.nan)
        readings = self._low_pass(one.stamp_ns, readings)
        measured = sensing.measure_instant(readings.tolist())
        loaded = self._switch.update(measured[LEFT].force, measured[RIGHT].force)
        left, right = (
            foot if load else FootInstant(foot.force, None, extrapolating=False)
            for foot, load in zip(measured, loaded, strict=True)
        )
        wrench = _together((left, right), loaded, turn)
        both = None
        if wrench is not None and any(loaded):
            both = (-wrench[2] / wrench[0], wrench[1] / wrench[0])
        reported, frame = self._reported(one.new), self._switch.frame
        return Live(one.stamp_ns, (left, right), reported, frame, wrench, both, loaded, readings)

    def _reported(self, new: BoolArray) -> tuple[bool, bool]:
        """Of which feet there is something new; nearly always of both."""
        if new.all():
            return True, True
        on_left, on_right = self._of_foot
        return bool(new[on_left].any()), bool(new[on_right].any())


class _Turn:
    """Wrenches in the right sole's frame -> the left one's; see `wrench.to_left`."""

    def __init__(self, support: DoubleSupport) -> None:
        self._dx, self._dy = support.dx, support.dy
        self._cosine, self._sine = math.cos(support.dtheta), math.sin(support.dtheta)

    def __call__(self, wrench: Wrench) -> Wrench:
        force, about_x, about_y = wrench
        return (
            force,
            self._dy * force + self._cosine * about_x - self._sine * about_y,
            -self._dx * force + self._sine * about_x + self._cosine * about_y,
        )


def wrench_of(foot: FootInstant) -> Wrench:
    """F [N], Mx, My [N m] about the foot's sole origin; no moments without a CoP."""
    if foot.cop is None:
        return foot.force, 0.0, 0.0
    x, y = foot.cop
    return foot.force, y * foot.force, -x * foot.force


def _together(
    feet: tuple[FootInstant, FootInstant], loaded: tuple[bool, bool], turn: _Turn | None
) -> Wrench | None:
    """Wrench of both feet in the sole frame of the left one while it carries load.

    None without joint angles, on one foot, too: such a robot may step at any moment.
    """
    left, right = feet
    if turn is None or math.isnan(left.force) or math.isnan(right.force):
        return None
    if any(load and foot.cop is None for load, foot in zip(loaded, feet, strict=True)):
        return None
    if all(loaded):
        ours, theirs = wrench_of(left), turn(wrench_of(right))
        return ours[0] + theirs[0], ours[1] + theirs[1], ours[2] + theirs[2]
    total = left.force + right.force
    cop = feet[loaded.index(True)].cop if any(loaded) else None
    return wrench_of(FootInstant(total, cop, extrapolating=False))
