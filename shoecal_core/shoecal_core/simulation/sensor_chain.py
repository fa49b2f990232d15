"""From what channels feel to what reaches their converter, instant by instant."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.simulation.sampled_parts import SampledShoes
from shoecal_core.simulation.stage import Instant

NO_SIDEWAYS = np.zeros((2, 2))


class SensorChain:
    """All stages in their order, then the age of a reading.

    `take` moves on in time, `latest` and `at` look. A chain is moved on at instants of the physics'
    own, so what it gives does not depend on who looks when.

    Attributes:
        time: of the last instant taken, since the session began [s].
        run: of the session that goes on, from 1; 0 before the first.
        active: whether it changes anything.
        feels_sideways: whether a stage needs the floor's sideways forces.
    """

    def __init__(self, shoes: SampledShoes, time: float = 0.0) -> None:
        """Nothing stands on the shoes; the session has run for some time [s]."""
        self._stages = sorted(shoes.stages, key=lambda stage: stage.place)
        self._states: list[Any] = [stage.start() for stage in self._stages]
        self._latency = shoes.latency
        self._late = np.flatnonzero(shoes.latency)
        self._longest = float(shoes.latency.max(initial=0.0))
        self._past: deque[tuple[float, FloatArray]] = deque()
        self._nothing = np.zeros(len(shoes.channels))
        self.time, self.run = time, 0
        self._last = self._nothing
        self.active = bool(self._stages) or self._late.size > 0
        self.feels_sideways = any(stage.feels_sideways for stage in self._stages)

    def lift(self) -> None:
        """Take all load off, between two instants; late readings of before are lost."""
        self._past.clear()
        self._last, self._states = self._pass(self._nothing, self.time, NO_SIDEWAYS)

    def take(self, felt: FloatArray, time: float, sideways: FloatArray = NO_SIDEWAYS) -> None:
        """Move on.

        Args:
            felt: (n,) by the channels [N or N m].
            time: since the session began, not before the one of the last call [s].
            sideways: (2, 2) the floor's force on left, right along x, y of its sole frame [N].
        """
        signal, self._states = self._pass(felt, time, sideways)
        self.time, self._last = time, signal
        if self._late.size:
            self._past.append((time, signal))
            while len(self._past) > 2 and self._past[1][0] < time - self._longest:
                self._past.popleft()

    def latest(self) -> FloatArray:
        """(n,) what reached the converter at the instant taken last [N or N m]."""
        return self._late_ones(self._last, self.time)

    def at(self, felt: FloatArray, time: float, sideways: FloatArray = NO_SIDEWAYS) -> FloatArray:
        """(n,) what reaches the converter at an instant that is not taken [N or N m].

        Arguments as `take`.
        """
        signal, _ = self._pass(felt, time, sideways)
        return self._late_ones(signal, time)

    def _late_ones(self, signal: FloatArray, time: float) -> FloatArray:
        """The signal (n,) with late channels as they were."""
        if not self._late.size:
            return signal
        known = (*self._past, (time, signal))
        times, past = (np.array(column) for column in zip(*known, strict=True))
        late = signal.copy()
        for channel in self._late:
            late[channel] = np.interp(time - self._latency[channel], times, past[:, channel])
        return late

    def _pass(
        self, felt: FloatArray, time: float, sideways: FloatArray
    ) -> tuple[FloatArray, list[Any]]:
        instant = Instant(time, time - self.time, sideways, self.run)
        signal, states = felt, []
        for stage, before in zip(self._stages, self._states, strict=True):
            signal, state = stage(signal, before, instant)
            states.append(state)
        return signal, states
