"""Voltages as they come, joined into all channels; says what is wrong with them."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence

import numpy as np

from shoecal_core.arrays import IntArray
from shoecal_core.errors import ShoecalError
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.health import Condition
from shoecal_ros.common.voltage_frame import VoltageFrame
from shoecal_ros.inputs.arrival_monitor import SILENT_S, ArrivalMonitor
from shoecal_ros.inputs.cell_watch import CellWatch
from shoecal_ros.inputs.joining import BoardsApartError, FrameJoiner, Joined
from shoecal_ros.inputs.lost_frames import LostFrames

REMEMBER_S = 3.0
"""How long a frame that could not be used is reported after it came, by the wall clock."""


class VoltageInput:
    """What the devices send.

    Attributes:
        latest: the last instant of all channels, None before there was one.
        heard: since when there was none.
        feet: since when nothing came of a foot that fits the other's readings.
        temperature: that a device reported last [degC], NaN where none does.
    """

    def __init__(
        self,
        joiner: FrameJoiner,
        stale_s: float,
        *,
        silent_s: float = SILENT_S,
        watch: CellWatch | None = None,
        of_foot: Sequence[IntArray] = (),
    ) -> None:
        """Nothing heard.

        Args:
            joiner: of the frames, whose clock is this one's, too.
            stale_s: without frames for that long there is a problem, by the wall clock [s].
            silent_s: for that long at least, they are silent [s].
            watch: marks readings of broken cells.
            of_foot: indices of each foot's channels, where feet are asked for.
        """
        self._joiner = joiner
        self._stale_s = stale_s
        self._watch = watch
        self._clock = joiner.clock
        self._began = joiner.clock()
        self.heard = ArrivalMonitor(joiner.clock, silent_s)
        self.feet = tuple(ArrivalMonitor(joiner.clock, silent_s) for _ in of_foot)
        self._of_foot = of_foot
        self._lost = LostFrames()
        self._trouble: Problem | None = None
        self._troubled = -np.inf
        self.latest: Joined | None = None
        self.temperature = math.nan

    @property
    def latest_ns(self) -> int | None:
        """Stamp of the last instant [ns], None before there was one."""
        return None if self.latest is None else self.latest.stamp_ns

    @property
    def sources(self) -> Collection[str]:
        """Devices that have sent cells' readings, by the frame_id of their messages."""
        return self._lost.sources

    @property
    def fresh(self) -> bool:
        """Whether all channels have come lately enough to go on, in whatever state."""
        return self.heard.age_s <= self._stale_s

    @property
    def problem(self) -> Problem | None:
        """What is wrong at the moment and its cure, None when all is well."""
        now = self._clock()
        if now - self._troubled < REMEMBER_S:
            return self._trouble
        if not self.fresh:
            if self.latest is None:
                return Problem(Code.NO_VOLTAGES, "no voltages yet; start shoe_driver")
            reported = f"no voltages for {self.heard.age_s:.0f} s; check shoe_driver and its device"
            return Problem(Code.VOLTAGES_STALE, reported)
        missing = self._joiner.missing
        if missing and now - self._began > REMEMBER_S:
            return Problem(
                Code.CELL_NOT_SENT,
                f"no device sends the voltage of {', '.join(missing)}; correct the driver's "
                "channels or the shoe file",
            )
        return None

    @property
    def condition(self) -> Condition:
        """What is wrong with them, and how many come, for diagnostics."""
        figures = {
            **self.heard.figures(),
            "lost_frames": str(self._lost.count),
            "left_out_frames": str(self._joiner.left_out),
        }
        return Condition.of(self.problem, "voltages come", figures)

    def refuse(self, problem: Problem) -> None:
        """Something that came could not be used."""
        self._trouble, self._troubled = problem, self._clock()

    def take(self, frames: Iterable[VoltageFrame]) -> list[Joined]:
        """Take frames in order; what they give."""
        given = [self._add(frame) for frame in frames]
        instants = [one for one in given if one is not None]
        for heard, own in zip(self.feet, self._of_foot, strict=True):
            # Not by instants: one may wait a period for the other board.
            came = self._joiner.fitted_s(own)
            if came > heard.at:
                heard.note(at=came)
        if instants:
            if self._watch is not None:
                instants = self._watch.take(instants)
            self.heard.note(len(instants))
            self.latest = instants[-1]
        return instants

    def _add(self, frame: VoltageFrame) -> Joined | None:
        """What a frame gives; None where it could not be used, too."""
        try:
            joined = self._joiner.add(frame)
        except BoardsApartError as error:
            # It has come all the same, and its source will be well again.
            self.refuse(Problem.of(error))
            joined = None
        except ShoecalError as error:
            self.refuse(Problem.of(error))
            return None
        if frame.cells:  # one that sends none may have any name: nothing is kept of it
            self._lost.note(frame.source, frame.sequence)
        if not math.isnan(frame.temperature):
            self.temperature = frame.temperature
        return joined
