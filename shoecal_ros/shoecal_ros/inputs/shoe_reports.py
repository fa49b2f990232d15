"""What the shoes report: that readings come, and which feet carry load."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from shoecal_msgs.msg import ShoeState

from shoecal_core.shoe.shoe import FEET
from shoecal_ros.inputs.arrival_monitor import ArrivalMonitor

BEATS, BEAT_S = 5, 0.5
"""So many states, each so soon after the one before, come at a rate."""
JOB_S = 3.0
"""Without a state for so long, ten of which come a second, a job's node hangs or is gone."""


class ShoeReports:
    """Readings are only counted here; the calibrator makes forces of them.

    Attributes:
        heard: when readings last came.
    """

    def __init__(
        self,
        reported: Callable[[], bool] = lambda: True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Nothing heard.

        Args:
            reported: whether a node is there that would publish a new state.
            clock: monotonic [s].
        """
        self._reported = reported
        self._clock = clock
        self.heard = ArrivalMonitor(clock)
        self._state_times: deque[float] = deque(maxlen=BEATS)
        self._state: ShoeState | None = None
        self._useless_since: dict[str, float] = {}

    def take_readings(self, messages: Sequence[Any]) -> None:
        """Take messages of `shoe/voltages`, serialised or not."""
        if messages:
            self.heard.note(len(messages))

    def take_states(self, messages: Sequence[ShoeState]) -> None:
        """Take messages of `shoe/state`."""
        for message in messages:
            self._state = message
            self._state_times.append(self._clock())
            for foot in message.feet:
                # Under a calibration that the robot contradicts readings are of use all the same:
                # it has to move to be calibrated again.
                doubted = message.unconfirmed or message.disagrees
                good = foot.valid or (doubted and not any(foot.status))
                if good and not foot.stale:
                    self._useless_since[foot.foot] = np.inf
                    continue
                # What never sent anything of use does not fall silent.
                since = self._useless_since.setdefault(foot.foot, -np.inf)
                self._useless_since[foot.foot] = min(since, self._clock())

    @property
    def ages(self) -> dict[str, float]:
        """By source, since when it has sent nothing of use; infinite where it never did [s].

        Readings of a foot of which a cell is broken are of no use: whether it carries is not known.
        """
        now = self._clock()
        ages = {"shoe/voltages": self.heard.age_s}
        if self._state is not None:
            ages["shoe/state"] = self._state_age if self._reported() else np.inf
            for foot in self._state.feet:
                since = min(self._useless_since[foot.foot], now)
                ages[f"readings of the {foot.foot} foot"] = now - since
        return ages

    @property
    def job(self) -> str:
        """Run id of the job under way that moves the robot; empty: none."""
        if self._state is None or not self._reported() or self._state_age >= JOB_S:
            return ""
        return str(self._state.run_id)

    @property
    def _state_age(self) -> float:
        """Since when no state came; none where they only come at changes [s]."""
        times = self._state_times
        beats = len(times) == BEATS and times[-1] - times[0] < BEATS * BEAT_S
        return self._clock() - times[-1] if beats else 0.0

    @property
    def loaded(self) -> tuple[bool | None, bool | None]:
        """Whether the left and the right foot carry load; None where unknown.

        Unknown until a calibration is in force.
        """
        left, right = (self._of(foot) for foot in FEET)
        return left, right

    def _of(self, name: str) -> bool | None:
        if self._state is None or not self._reported():
            return None
        foot = next((foot for foot in self._state.feet if foot.foot == name), None)
        return bool(foot.loaded) if foot is not None and foot.valid and not foot.stale else None
