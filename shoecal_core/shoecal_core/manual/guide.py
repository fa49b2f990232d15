"""What a person is asked to do next, as a state machine without clock, terminal or file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from enum import Enum

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.manual.calibrate import of_shoe
from shoecal_core.manual.cells import wrong_response
from shoecal_core.manual.loads import Load
from shoecal_core.manual.measurements import EntryError, LoadReading, Measurements
from shoecal_core.manual.settings import ManualSettings
from shoecal_core.manual.shoe_loads import wrong_weight
from shoecal_core.manual.still import Last, StillReading, StillState
from shoecal_core.robot.gravity import GRAVITY

Check = Callable[[Measurements, LoadReading], str]


class GuidePhase(Enum):
    """Where the guide is."""

    ASKING = "asking"
    READING = "reading"
    COMPLETE = "complete"
    STOPPED = "stopped"


class Key(Enum):
    """What a person can say."""

    READ = "read"
    REPEAT = "repeat"
    BACK = "back"
    SKIP = "skip"
    STOP = "stop"


class Guide:
    """Leads through a plan of loads; starts at the first that was not read yet.

    Attributes:
        plan: every load, in order.
        measurements: what has been read.
        phase: asking for a load, reading it, or at the end.
        skipped: loads left out in this session.
    """

    def __init__(
        self,
        plan: Sequence[Load],
        measurements: Measurements,
        settings: ManualSettings,
        check: Check,
    ) -> None:
        """Ask for the first load.

        Args:
            plan: one or more loads.
            measurements: of an earlier session, or none.
            settings: what a still reading is.
            check: of what was read before and a new reading: what is wrong with the new one.
        """
        self.plan = tuple(plan)
        self.measurements = measurements
        self.skipped: set[Load] = set()
        self._settings = settings
        self._check = check
        self._at = -1
        self._said = ""
        self._last: Last | None = None
        self._reading: StillReading | None = None
        self.phase = GuidePhase.ASKING
        self._next()

    @property
    def load(self) -> Load:
        """The load that is asked for or read."""
        return self.plan[self._at]

    @property
    def number(self) -> int:
        """Its place in the plan, from 1."""
        return self._at + 1

    @property
    def pending(self) -> int:
        """Loads of the plan that have not been read."""
        return sum(load not in self.measurements.loads for load in self.plan)

    @property
    def gathered(self) -> int:
        """Samples in a row of the reading under way."""
        return 0 if self._reading is None else self._reading.gathered

    def news(self) -> str:
        """What became of the last reading or key, once; empty when there is nothing new."""
        said, self._said = self._said, ""
        return said

    def press(self, key: Key) -> None:
        """Take what the person says; at the end nothing is heard any more."""
        if self.phase in {GuidePhase.COMPLETE, GuidePhase.STOPPED}:
            return
        if key is Key.STOP:
            self._reading, self.phase = None, GuidePhase.STOPPED
        elif key is Key.READ:
            if self.phase is GuidePhase.ASKING:
                shoe = self.measurements.shoe
                self._reading = StillReading(shoe, self.load, self._settings, self._last)
                self.phase = GuidePhase.READING
        elif key is Key.SKIP:
            self.skipped.add(self.load)
            self._ask("skipped")
            self._next()
        elif key is Key.BACK:
            self._ask("")
            self._at = max(0, self._at - 1)
        elif self._last is not None:
            self._ask("once more")
            self._at = self.plan.index(self._last.load)

    def take(self, readings: FloatArray, stamp_ns: int) -> None:
        """Take all channels (n,) at one instant [unit]; while asking it does nothing.

        Args:
            readings: NaN where a channel gave none.
            stamp_ns: when they were sampled, 0 where not known.
        """
        if self._reading is None:
            return
        outcome = self._reading.take(readings[self.measurements.shoe.of_foot(self.load.foot)])
        if outcome is StillState.UNDER_WAY:
            return
        if outcome is not StillState.STILL:
            self._ask(outcome.value)
            return
        reading = self._reading
        entry = LoadReading(self.load, reading.mean, reading.std, self._settings.samples, stamp_ns)
        problem = self._accept(entry)
        self._ask(problem)
        if not problem:
            self._last = Last(entry.load, entry.mean)
            self._next()

    def _accept(self, entry: LoadReading) -> str:
        """Keep a reading; what is wrong with it where it is not kept."""
        try:
            fresh = self.measurements.with_entry(entry)
        except EntryError as error:
            return error.problem
        problem = self._check(self.measurements, entry)
        if not problem:
            self.measurements = fresh
            self.skipped.discard(entry.load)
        return problem

    def _ask(self, said: str) -> None:
        self._reading, self._said, self.phase = None, said, GuidePhase.ASKING

    def _next(self) -> None:
        """Go on to the next load that is neither read nor skipped, behind this one if there is."""
        done = self.measurements.loads | self.skipped
        count = len(self.plan)
        for step in range(1, count + 1):
            index = (self._at + step) % count
            if self.plan[index] not in done:
                self._at = index
                return
        self.phase = GuidePhase.COMPLETE


def cell_check(before: Measurements, entry: LoadReading) -> str:
    """Whether another cell than the loaded one responded, or none; empty: all is well."""
    name = entry.load.place
    weights = {other.load.mass for other in before.of_cell(name) if other.load != entry.load}
    if not weights:
        return ""
    return wrong_response(before.with_entry(entry), name)


def shoe_check(cells: Calibration) -> Check:
    """Whether another weight is there than was asked for.

    Args:
        cells: calibration of the single cells.
    """

    def check(before: Measurements, entry: LoadReading) -> str:
        load = entry.load
        bare = [other for other in before.of_foot(load.foot) if not other.load.place]
        if not load.place or not bare:
            return ""
        one = before.shoe.of_one_foot(load.foot)
        gain = of_shoe(cells, one).parameters.gain
        return wrong_weight(
            load, float(np.sum(gain * (entry.mean - bare[0].mean))), load.mass * GRAVITY
        )

    return check
