"""Device time to host time, without any help from the device.

A frame is received after it was sampled, by a delay that jitters: serial adapters hold bytes,
the scheduler is late. So receive time minus device time never falls below the true offset
between the clocks, and its lower envelope over a window follows that offset. The envelope is
the straight line below all points with the least sum of distances (the answer of greatest
likelihood for exponential delays): the edge of their convex hull above which their mean lies.

Simulated time breaks the assumption: the host's clock arrives as messages, in coarse steps,
itself late, and a fast simulation stretches every delay. But then the device counts the same
time. So where the host's clock is coarse and agrees with the device's, they are one clock.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

WINDOW_NS = 20_000_000_000
BUCKET_NS = 100_000_000
"""The window keeps the least delayed point of every bucket."""
MIN_SPAN_NS = 2_000_000_000
"""Shorter stretches of points give an offset, but no drift."""
MAX_DRIFT = 0.05
"""Between two clocks; RC oscillators miss by some per cent."""

JUMP_BACK_NS, JUMP_NS = 80_000_000, 100_000_000
"""Receipt so long before sampling: a clock was set. So much later than any before, and it stays so
for SETTLE_NS on both clocks: likewise. Time services step a clock by 128 ms and more."""
SETTLE_NS = 1_000_000_000
LONGEST_DELAY_NS = 10_000_000_000
"""Receipt so late: a clock was set or stood still, for nothing holds bytes that long."""
LONGEST_HELD_NS = 500_000_000
"""Frames received together may have waited so much longer than those before."""
TINY_BACK_NS = 1_000_000
"""A device time that goes back by so little is that of a clock read unevenly, of no new one."""

COARSE_NS = 100_000
"""A host clock that ticks in steps this long or longer is a simulated one."""
ROUNDING_NS = 10_000
SAME_CLOCK_NS = 500_000_000
"""Clocks this near to each other may be one clock, if the host's is coarse."""


@dataclass
class _Point:
    """Device time, and receive time minus device time from an origin [ns]."""

    device: int
    late: int


class DeviceClock:
    """Maps one device's time to the host's; both may jump or start again.

    Attributes:
        resets: how often the mapping was started again.
    """

    def __init__(self) -> None:
        self.resets = 0
        self._receipt: int | None = None
        self._given = 0
        self._begin()

    @property
    def drift(self) -> float:
        """Seconds the host's clock gains on the device's in a second."""
        return 0.0 if self._same else self._drift

    @property
    def same_clock(self) -> bool:
        """Whether the device is taken to count the host's own time."""
        return self._same

    def restart(self) -> None:
        """Start again: the device has restarted."""
        self.resets += 1
        self._begin()

    def stamps(self, device_us: Iterable[int], receive_ns: int) -> list[int]:
        """Host times [ns] at which the device's clock showed `device_us`.

        They grow strictly, unless the host's clock was set back.

        Args:
            device_us: device clock at each sampling [us], of frames received together. The
                last of them was delayed least, and corrects the others.
            receive_ns: host clock when they were received [ns].
        """
        if receive_ns < self._given - JUMP_BACK_NS:
            self._given = 0
        longest = self._longest_gap(receive_ns)
        stamps: list[int] = []
        batch: list[int] = []
        for device in (time * 1000 for time in device_us):
            if batch and not -TINY_BACK_NS <= device - batch[-1] <= longest:
                stamps += self._batch(batch, receive_ns)
                batch = []
            batch.append(device)
        return stamps + self._batch(batch, receive_ns)

    def _longest_gap(self, receive_ns: int) -> int:
        """Device time that may lie between two frames received together [ns].

        Both were sent since the last receipt, but for the delay; a longer gap is a device clock
        that jumped, and what came before it would be stamped years ago.
        """
        since, self._receipt = self._receipt, receive_ns
        if since is None:
            return WINDOW_NS
        return round(max(0, receive_ns - since) * (1 + MAX_DRIFT)) + LONGEST_HELD_NS

    def _begin(self) -> None:
        self._points: list[_Point] = []
        self._origin = 0
        self._foot = _Point(0, 0)
        self._drift = 0.0
        self._late_since: tuple[int, int] | None = None
        self._last: tuple[int, int] | None = None
        self._ticks = 0
        self._same = False
        self._same_until = 0

    def _batch(self, devices: list[int], receive_ns: int) -> list[int]:
        """Stamps of device times [ns] that grow but for tiny steps back, received together."""
        if not devices:
            return []
        newest = devices[-1]
        restarted = self._last is not None and devices[0] < self._last[0] - TINY_BACK_NS
        if restarted or self._jumped(newest, receive_ns):
            self.restart()
        self._recognise(newest, receive_ns)
        if not self._points:
            self._origin = receive_ns - newest
        self._add(_Point(newest, receive_ns - newest - self._origin))
        return [self._stamp(device) for device in devices]

    def _stamp(self, device: int) -> int:
        """Host time [ns] of a device time [ns] by what is known now."""
        stamp = device if self._same else device + self._origin + math.floor(self._line(device))
        if self._last is not None:
            last_device, last_stamp = self._last
            # A corrected mapping may slow the stamps down, but not turn them back.
            stamp = max(stamp, last_stamp + max(1, (device - last_device) // 2))
        self._last = device, stamp
        # A mapping started again turns them back no more than that.
        self._given = max(stamp, self._given + 1)
        return self._given

    def _line(self, device: int) -> float:
        """Lower envelope at a device time, from the origin [ns]."""
        return self._foot.late + self._drift * (device - self._foot.device)

    def _recognise(self, device: int, receive_ns: int) -> None:
        """Decide whether device and host share a simulated clock."""
        self._ticks = math.gcd(self._ticks, (receive_ns + ROUNDING_NS // 2) // ROUNDING_NS)
        coarse = self._ticks >= COARSE_NS // ROUNDING_NS
        if coarse and abs(receive_ns - device) <= SAME_CLOCK_NS:
            if not self._same and self._last is not None:
                self.restart()
            self._same = True
            self._same_until = device + WINDOW_NS
        elif not coarse or device > self._same_until:
            self._same = False

    def _jumped(self, device: int, receive_ns: int) -> bool:
        """Whether a clock was set, so that the points so far say nothing any more."""
        if self._same or not self._points:
            return False
        if self._last is not None and receive_ns < self._last[1] - JUMP_BACK_NS:
            # By and by, as where the host's clock stands: every receipt seems less delayed.
            return True
        excess = receive_ns - device - self._origin - self._line(device)
        if not -JUMP_BACK_NS <= excess <= LONGEST_DELAY_NS:
            return True
        if excess < JUMP_NS:
            self._late_since = None
            return False
        if self._late_since is None:
            self._late_since = (device, receive_ns)
        return device - self._late_since[0] > SETTLE_NS < receive_ns - self._late_since[1]

    def _add(self, point: _Point) -> None:
        """Take a point into its bucket; fit again whenever a bucket is complete."""
        points = self._points
        ahead = point.device // BUCKET_NS - points[-1].device // BUCKET_NS if points else 1
        if ahead < 0:
            return
        if not ahead:
            if self._line_excess(point) < self._line_excess(points[-1]):
                points[-1] = point
        else:
            while points and points[0].device < point.device - WINDOW_NS:
                points.pop(0)
            if points:
                self._fit()
            points.append(point)
        if len(points) == 1 or self._line_excess(point) < 0:
            self._foot = points[-1]

    def _line_excess(self, point: _Point) -> float:
        return point.late - self._line(point.device)

    def _fit(self) -> None:
        """Lower envelope of the window."""
        points = self._points
        if points[-1].device - points[0].device < MIN_SPAN_NS:
            self._foot = min(points, key=self._line_excess)
            return
        left, right = _edge_below_mean(points)
        drift = (right.late - left.late) / (right.device - left.device)
        self._foot, self._drift = right, min(max(drift, -MAX_DRIFT), MAX_DRIFT)


def _edge_below_mean(points: list[_Point]) -> tuple[_Point, _Point]:
    """Ends of the lower convex hull's edge that spans the mean device time."""
    hull: list[_Point] = []
    for point in points:
        while len(hull) > 1 and not _turns_left(hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    mean = sum(point.device for point in points) / len(points)
    right = next(index for index in range(1, len(hull)) if hull[index].device >= mean)
    return hull[right - 1], hull[right]


def _turns_left(a: _Point, b: _Point, c: _Point) -> bool:
    return (b.device - a.device) * (c.late - a.late) > (c.device - a.device) * (b.late - a.late)
