"""Voltages of one instant from one board or several."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np
from numpy.typing import NDArray
from shoecal_msgs.msg import ShoeVoltages

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.errors import ShoecalError
from shoecal_core.settings import Settings, setting
from shoecal_ros.common.voltage_frame import VoltageFrame

NO_DATA = ShoeVoltages.NO_DATA
CLOCK_SET_NS = 1_000_000_000
"""Stamps that fall back further than this: a clock was set, or simulated time started again."""
HOLD_PERIODS, MOST_HOLD_S = 1.5, 0.15
"""A reading counts for so many of its board's periods at least, else two slow boards never meet;
but for no longer than this: what is older is not of the same instant."""
_INTERVALS, _LEAST_INTERVALS = 5, 3
_STEPS = 50
_BACK = 3
"""More steps back of a counter than this in so many: two devices send the same cells."""
_GONE_S = 1.0
"""A source that has sent nothing for so long, by the wall clock, has its cells no longer."""
_APART_S = 1.0
"""Who is behind the others by the same time for so long has another clock."""
_MOST_BETWEEN = 3
"""So many frames of others, and _GONE_S, without one of a board that was ahead: it is gone."""
NEVER_NS = -(2**62)
"""Stamp of what has not come."""
_MOST_HOLD_NS = round(MOST_HOLD_S * 1e9)
_MOST_STREAMS = 64
"""Sets of cells that frames may carry: a board has one, or a few in turn."""


class TwoSourcesError(ShoecalError):
    """One cell's voltage comes from two places."""


class BoardsApartError(ShoecalError):
    """Boards whose stamps are of different clocks."""


class UnsteadyCellsError(ShoecalError):
    """Frames of one source carry ever other cells."""


class UnknownCellError(ShoecalError):
    """A voltage of a cell that the shoe does not have."""


@dataclass(frozen=True)
class JoinSettings(Settings):
    """How frames of several boards meet."""

    hold_s: float = setting(
        0.04,
        "s",
        "for how long a cell's reading counts with those of other boards, or for "
        f"{HOLD_PERIODS:g} of its own board's periods if that is longer, but at most for "
        f"{MOST_HOLD_S:g} s",
        minimum=1e-3,
        maximum=MOST_HOLD_S,
    )


@dataclass(frozen=True)
class Joined:
    """All channels at one instant.

    Attributes:
        stamp_ns: time of sampling of the board that gives the instants [ns].
        readings: (n,) in the shoe's order, NaN where none came.
        status: (n,) constants of ShoeVoltages.
        new: (n,) which were sent since the instant before; others are that one's still.
    """

    stamp_ns: int
    readings: FloatArray
    status: NDArray[np.uint8]
    new: BoolArray


class _Stream:
    """Frames of one source that carry the same cells."""

    def __init__(self, columns: IntArray) -> None:
        self.columns = columns
        self.in_order = bool(np.all(np.diff(columns) == 1))
        self._sequence: int | None = None
        self._back: deque[bool] = deque(maxlen=_STEPS)
        self._intervals: deque[int] = deque(maxlen=_INTERVALS)
        self.stamp_ns = NEVER_NS
        self.behind: tuple[float, int] | None = None

    def note(self, stamp_ns: int) -> None:
        """A frame, of a later instant unless the clock was set back."""
        if stamp_ns > self.stamp_ns > NEVER_NS:
            self._intervals.append(stamp_ns - self.stamp_ns)
        self.stamp_ns = stamp_ns

    @property
    def period_ns(self) -> float:
        """From one frame to the next, by their stamps [ns]; 0 before there were a few."""
        return median(self._intervals) if len(self._intervals) >= _LEAST_INTERVALS else 0.0

    def doubled(self, sequence: int) -> bool:
        """Whether the counter runs back too often for one device."""
        if self._sequence is not None:
            step = (sequence - self._sequence) % 2**32
            self._back.append(step == 0 or step >= 2**31)
        self._sequence = sequence
        return sum(self._back) > _BACK


class FrameJoiner:
    """Joins frames, each with any subset of the cells, into all channels.

    A cell's last reading counts for a little while, as long as the next one may take. The frames
    that carry the cell heard first give the instants; those of another one as soon as it is late.

    Attributes:
        clock: monotonic [s].
        left_out: frames whose stamps were not later than those before them.
    """

    def __init__(
        self,
        channels: Sequence[str],
        hold_s: float,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing heard.

        Args:
            channels: n names, the shoe's.
            hold_s: for how long a reading counts at least [s].
            clock: monotonic [s].
        """
        self.clock = clock
        self._column = {name: index for index, name in enumerate(channels)}
        self._names = tuple(channels)
        self._hold_ns = round(hold_s * 1e9)
        self._all_new = np.ones(len(channels), dtype=np.bool_)
        self._reference = 0
        self.left_out = 0
        self._came = np.full(len(channels), -np.inf)
        self._fits = self._came.copy()
        self._whole_s = self._part_s = -np.inf
        self._between, self._period_ns = 0, 0.0
        self.forget()

    def forget(self) -> None:
        """Start again: boards may have been plugged differently."""
        self._streams: dict[tuple[str, tuple[str, ...]], _Stream] = {}
        self._owner: dict[str, str] = {}
        self._heard: dict[str, float] = {}
        self._restart()

    @property
    def missing(self) -> tuple[str, ...]:
        """Channels that have not been sent."""
        return tuple(name for name in self._names if name not in self._owner)

    def fitted_s(self, columns: IntArray) -> float:
        """When the last reading of channels (k,) came that an instant has or will have [s]."""
        if self._whole_s >= self._part_s:
            return self._whole_s
        return max(self._whole_s, float(self._fits[columns].max()))

    def add(self, frame: VoltageFrame) -> Joined | None:
        """Take one frame; all channels when it gives an instant.

        Raises:
            BoardsApartError: for a frame with stamps far behind those of others, as before; it is
                left out.
            TwoSourcesError: when a cell comes from two places; likewise.
            UnknownCellError: for a cell the shoe does not have; likewise.
            UnsteadyCellsError: for yet another set of cells after very many; likewise.
        """
        if not frame.cells:
            # A device whose channels have no names: its driver says so.
            return None
        stream = self._stream(frame)
        now = self._heard[frame.source] = self.clock()
        if stream.doubled(frame.sequence):
            raise TwoSourcesError(
                f"two drivers named '{frame.source}' send {', '.join(frame.cells)}; stop one of "
                "them, or let each send its own cells"
            )
        stamp = frame.stamp_ns
        if stamp <= stream.stamp_ns:
            if stream.stamp_ns - stamp < CLOCK_SET_NS:
                self.left_out += 1
                return None
            self._restart()
        stream.note(stamp)
        columns = stream.columns
        if len(columns) == len(self._names) and stream.in_order:
            # One board sends all there is: there is nothing to join.
            self._readings[:], self._status[:], self._stamps[:] = frame.voltage, frame.status, stamp
            self._new[:] = False
            self._came[:] = now
            self._instant_ns, self._whole_s = stamp, now
            return Joined(stamp, frame.voltage, frame.status, self._all_new)
        self._came[columns] = now
        self._readings[columns] = frame.voltage
        self._status[columns] = frame.status
        self._stamps[columns] = stamp
        self._new[columns] = True
        self._holds[columns] = min(
            max(self._hold_ns, HOLD_PERIODS * stream.period_ns), _MOST_HOLD_NS
        )
        if self._late(stamp, now):
            self._reference = int(columns[0])
        if self._reference not in columns:
            self._between += 1
            self._follow(stream, frame, now)
            return None
        self._between = 0
        stream.behind = None
        self._part_s, self._period_ns = now, stream.period_ns
        return self._instant(stamp)

    def _late(self, stamp: int, now: float) -> bool:
        """Whether the board that gives the instants is, compared with a frame that came now."""
        silent = self._between >= _MOST_BETWEEN and now - self._came[self._reference] > _GONE_S
        if silent and self._stamps[self._reference] > stamp:
            # Gone, whatever its stamps say.
            self._stamps[now - self._came > _GONE_S] = NEVER_NS
        return bool(stamp - self._stamps[self._reference] > self._hold_ns)

    def _instant(self, stamp: int) -> Joined | None:
        """What is known at a time; None where a board that is gone has given a later one."""
        if 0 <= self._instant_ns - stamp < CLOCK_SET_NS:
            self.left_out += 1
            return None
        self._instant_ns = stamp
        old = np.abs(stamp - self._stamps) > self._holds
        new = self._new & ~old
        self._fits[new] = self._came[new]
        self._new[:] = False
        return Joined(
            stamp,
            np.where(old, np.nan, self._readings),
            np.where(old, NO_DATA, self._status).astype(np.uint8),
            new,
        )

    def _follow(self, stream: _Stream, frame: VoltageFrame, now: float) -> None:
        """See whether a frame fits the instants; BoardsApartError where its board never does."""
        behind_ns = int(self._stamps[self._reference]) - frame.stamp_ns
        hold_ns = int(self._holds[stream.columns].max())
        if behind_ns + self._period_ns <= hold_ns:
            # The next instant will have it, and need not be waited for.
            stream.behind = None
            self._fits[stream.columns] = self._part_s = now
        elif stream.behind is None or abs(behind_ns - stream.behind[1]) > hold_ns:
            # It may be catching up.
            stream.behind = now, behind_ns
        elif now - stream.behind[0] > _APART_S:
            raise BoardsApartError(
                f"stamps of {', '.join(frame.cells)} are {behind_ns / 1e9:.2f} s behind those of "
                "the other cells, which come at the same time; let the computers of all drivers "
                "keep one clock"
            )

    def _restart(self) -> None:
        count = len(self._names)
        self._instant_ns = NEVER_NS
        self._status: NDArray[np.uint8] = np.full(count, NO_DATA, dtype=np.uint8)
        self._readings: FloatArray = np.full(count, np.nan)
        self._stamps: IntArray = np.full(count, NEVER_NS, dtype=np.int64)
        self._new: BoolArray = np.zeros(count, dtype=np.bool_)
        self._holds: IntArray = np.full(count, self._hold_ns, dtype=np.int64)

    def _stream(self, frame: VoltageFrame) -> _Stream:
        key = (frame.source, frame.cells)
        stream = self._streams.get(key)
        if stream is not None:
            return stream
        for cell in frame.cells:
            if cell not in self._column:
                raise UnknownCellError(
                    f"voltages of cell '{cell}', which the shoe file does not have (it has: "
                    f"{', '.join(self._names)}); correct the driver's channels or the shoe file"
                )
            if self._owned(cell, frame.source):
                raise TwoSourcesError(
                    f"cell '{cell}' comes from '{self._owner[cell]}' and from "
                    f"'{frame.source}'; give each cell one source"
                )
        if len(self._streams) >= _MOST_STREAMS:
            raise UnsteadyCellsError(
                f"'{frame.source}' sends ever other sets of cells; let each frame of a board carry "
                "the same ones"
            )
        stream = _Stream(np.array([self._column[cell] for cell in frame.cells], dtype=np.int64))
        self._streams[key] = stream
        self._owner.update(dict.fromkeys(frame.cells, frame.source))
        return stream

    def _owned(self, cell: str, source: str) -> bool:
        """Whether another source sends a cell; one that has fallen silent has none any more."""
        owner = self._owner.get(cell, source)
        if owner != source and self.clock() - self._heard[owner] > _GONE_S:
            self._heard.pop(owner)
            self._streams = {key: one for key, one in self._streams.items() if key[0] != owner}
            self._owner = {name: one for name, one in self._owner.items() if one != owner}
            return False
        return owner != source
