"""Readings -> what controllers get: each foot's force and CoP, and both together."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.sensing.sensing import Sensing
from shoecal_core.sensing.shoe import FEET
from shoecal_core.sensing.wrench import at_cop, to_left
from shoecal_ros.calibrator.load import LEFT, RIGHT, LoadSwitch
from shoecal_ros.inputs.joining import NO_DATA, Joined

FloatArray = NDArray[np.float64]
GOOD = 0


@dataclass(frozen=True)
class Foot:
    """One foot at one instant.

    Attributes:
        force: vertical [N], NaN where it is not known.
        cop: (2,) in its sole's frame [m]; None while it carries no load or is not known.
        extrapolating: outside what the CoP correction was made from.
    """

    force: float
    cop: FloatArray | None
    extrapolating: bool

    @property
    def wrench(self) -> FloatArray:
        """(3,) F [N], Mx, My [N m] about its sole's origin; no moments without a CoP."""
        if self.cop is None:
            return np.array([self.force, 0.0, 0.0])
        return at_cop(np.array(self.force), self.cop)


@dataclass(frozen=True)
class Live:
    """Both feet at one instant.

    Attributes:
        stamp_ns: time of sampling [ns].
        feet: left, right.
        frame: foot in whose sole frame `wrench` and `cop` are.
        wrench: (3,) of both feet; None where it is not known.
        cop: (2,) of both feet [m]; None where no foot carries load, or it is not known.
        loaded: which feet carry load.
    """

    stamp_ns: int
    feet: tuple[Foot, Foot]
    frame: int
    wrench: FloatArray | None
    cop: FloatArray | None
    loaded: tuple[bool, bool]


@dataclass(frozen=True)
class FootFlags:
    """What one foot's numbers are worth right now: see shoecal_msgs/msg/FootState."""

    loaded: bool
    valid: bool
    stale: bool
    extrapolating: bool
    status: tuple[int, ...]


class LowPass:
    """First-order low-pass of all channels; it delays them by `delay_s`."""

    def __init__(self, cutoff_hz: float) -> None:
        """No filter where the cut-off frequency is zero."""
        self.delay_s = 1.0 / (2.0 * math.pi * cutoff_hz) if cutoff_hz > 0.0 else 0.0
        self._state: FloatArray | None = None
        self._stamp_ns = 0

    def __call__(self, stamp_ns: int, readings: FloatArray) -> FloatArray:
        """Filtered readings (n,); what was not known or is not known starts anew."""
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
    """Turns joined readings into what is published.

    Attributes:
        sensing: under the calibration in force; None while uncalibrated.
    """

    def __init__(
        self, channel_feet: NDArray[np.int64], switch: LoadSwitch, low_pass: LowPass
    ) -> None:
        """Uncalibrated.

        Args:
            channel_feet: (n,) index of each channel's foot.
            switch: tells loaded feet.
            low_pass: of the readings.
        """
        self.sensing: Sensing | None = None
        self._of_foot = [np.flatnonzero(channel_feet == foot) for foot in range(len(FEET))]
        self._switch = switch
        self._low_pass = low_pass
        self._status = np.full(len(channel_feet), NO_DATA, dtype=np.uint8)
        self._last: Live | None = None

    def take(self, joined: Sequence[Joined], support: DoubleSupport | None) -> list[Live]:
        """Take readings in order; nothing comes out while uncalibrated.

        Args:
            joined: readings.
            support: where the right foot stands, None where nobody knows.
        """
        if not joined:
            return []
        self._status = joined[-1].status
        if self.sensing is None:
            self._last = None
            return []
        # A reading that is not good is none: a wrong number is worse than no number.
        readings = np.stack(
            [
                self._low_pass(one.stamp_ns, np.where(one.status == GOOD, one.readings, np.nan))
                for one in joined
            ]
        )
        measured = self.sensing.measure(readings)
        lives = [
            self._live(one.stamp_ns, force, cop, outside, support)
            for one, force, cop, outside in zip(
                joined, measured.grf, measured.cop, measured.extrapolating, strict=True
            )
        ]
        self._last = lives[-1]
        return lives

    def flags(self, *, stale: bool) -> tuple[FootFlags, FootFlags]:
        """How both feet fare, left and right.

        Args:
            stale: no fresh readings.
        """
        return self._flags(LEFT, stale), self._flags(RIGHT, stale)

    def _flags(self, foot: int, stale: bool) -> FootFlags:
        status = self._status[self._of_foot[foot]]
        known = self._last is not None and not stale
        own = None if self._last is None else self._last.feet[foot]
        return FootFlags(
            loaded=self._last is not None and self._last.loaded[foot],
            valid=known and own is not None and not math.isnan(own.force),
            stale=stale,
            extrapolating=own is not None and own.extrapolating,
            status=tuple(status.tolist()),
        )

    def _live(
        self,
        stamp_ns: int,
        force: FloatArray,
        cop: FloatArray,
        outside: NDArray[np.bool_],
        support: DoubleSupport | None,
    ) -> Live:
        loaded = self._switch.update(float(force[LEFT]), float(force[RIGHT]))
        left, right = (
            Foot(
                float(force[foot]),
                cop[foot] if loaded[foot] and np.isfinite(cop[foot]).all() else None,
                bool(outside[foot]) and loaded[foot],
            )
            for foot in (LEFT, RIGHT)
        )
        wrench = _together((left, right), loaded, support)
        both = None
        if wrench is not None and any(loaded):
            both = np.array([-wrench[2], wrench[1]]) / wrench[0]
        return Live(stamp_ns, (left, right), self._switch.frame, wrench, both, loaded)


def _together(
    feet: tuple[Foot, Foot], loaded: tuple[bool, bool], support: DoubleSupport | None
) -> FloatArray | None:
    """Wrench (3,) of both feet in the sole frame of the left one while it carries load."""
    if any(math.isnan(foot.force) for foot in feet):
        return None
    if any(load and foot.cop is None for load, foot in zip(loaded, feet, strict=True)):
        return None
    if all(loaded):
        if support is None:
            return None
        wrench: FloatArray = feet[LEFT].wrench + to_left(support) @ feet[RIGHT].wrench
        return wrench
    total = np.array(feet[LEFT].force + feet[RIGHT].force)
    if not any(loaded):
        return np.array([float(total), 0.0, 0.0])
    cop = feet[loaded.index(True)].cop
    assert cop is not None
    return at_cop(total, cop)
