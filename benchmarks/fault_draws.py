"""Draws of faulty sessions: what is drawn, what is put in, and what must be found."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from zlib import crc32

import numpy as np

from population import Member
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.screening.faults import Fault
from shoecal_core.shoe.shoe import Shoe

COARSE_SHARE = 1.0 / 3.0
"""Of the draws: cells with a poor converter and more noise than the recorded ones."""


class FaultySession(Session):
    """A recorded session of which some runs are replaced, in memory."""

    changed: Mapping[int, Run] = {}

    @staticmethod
    def of(folder: Path, changed: Mapping[int, Run]) -> FaultySession:
        """Open a session and replace some of its runs."""
        session = FaultySession.open(folder)
        assert isinstance(session, FaultySession)
        session.changed = changed
        return session

    def read(self, run: int) -> Run:
        """The replaced run, or the recorded one."""
        return self.changed[run] if run in self.changed else super().read(run)


class NoFaultError(ShoecalError):
    """The fault did not come about, or the robot fell: another draw is taken."""


@dataclass(frozen=True)
class Converter:
    """What a poor converter makes of readings.

    Attributes:
        bits: of a range of 10 V; None: readings stay as recorded.
        noise: standard deviation [V].
    """

    bits: int | None
    noise: float

    def read(self, run: Run, rng: np.random.Generator) -> Run:
        """The run as it would have been read."""
        if self.bits is None:
            return run
        step = 10.0 / 2**self.bits
        values = run.readings.value
        noisy = values + self.noise * rng.standard_normal(values.shape)
        return replace(run, readings=replace(run.readings, value=np.rint(noisy / step) * step))


@dataclass(frozen=True)
class Expected:
    """What must be found.

    Attributes:
        faults: its kind, or kinds that it may be taken for.
        words: all of them in one reason; empty where the list of what was left out names it.
        run: in which run.
        times: (K,) of the samples that must be left out, where the session is not refused [s].
        time_offset: joints late by [s], for clocks.
    """

    faults: tuple[Fault, ...]
    words: tuple[str, ...] = ()
    run: int | None = None
    times: FloatArray = field(default_factory=lambda: np.zeros(0))
    time_offset: float | None = None


@dataclass(frozen=True)
class Injected:
    """Runs with a fault, and what must be found of it."""

    runs: Mapping[int, Run]
    expected: Expected


@dataclass(frozen=True)
class Draw:
    """One draw: a member of the population, a converter, and chance for the rest.

    Attributes:
        fault: name of the kind.
        number: of the draw.
        member: whose session is spoilt.
        shoe: it wore.
        attempt: draws whose fault did not come about are drawn again.
    """

    fault: str
    number: int
    member: Member
    shoe: Shoe
    attempt: int = 0

    @cached_property
    def rng(self) -> np.random.Generator:
        """Chance of this draw alone."""
        return np.random.default_rng([crc32(self.fault.encode()), self.number, self.attempt])

    @cached_property
    def converter(self) -> Converter:
        """As recorded (24 bits, 10 mN of noise), or 10 to 12 bits and up to 0.15 N of noise."""
        if self.rng.uniform() > COARSE_SHARE:
            return Converter(None, 0.0)
        return Converter(int(self.rng.integers(10, 13)), float(self.rng.uniform(0.003, 0.0125)))

    @cached_property
    def runs(self) -> dict[int, Run]:
        """The session's runs, as the converter reads them."""
        session = Session.open(self.member.folder)
        return {
            entry.run: self.converter.read(session.read(entry.run), self.rng)
            for entry in session.runs
        }

    @property
    def least_spike(self) -> float:
        """Spikes that stand out from the noise [N]."""
        return max(1.0, 25.0 * 12.0 * self.converter.noise)

    def cell(self) -> int:
        """Any channel."""
        return int(self.rng.integers(len(self.shoe.names)))

    def run(self) -> int:
        """Any run."""
        return int(self.rng.choice(list(self.runs)))

    def name(self, cell: int) -> str:
        """Name of a channel."""
        return self.shoe.names[cell]

    def with_channel(
        self, cell: int, change: Callable[[FloatArray, int], FloatArray]
    ) -> dict[int, Run]:
        """All runs, one channel's readings (T,) changed by a function of them and the run."""
        runs = {}
        for number, run in self.runs.items():
            values = run.readings.value.copy()
            values[:, cell] = change(values[:, cell], number)
            runs[number] = replace(run, readings=replace(run.readings, value=values))
        return runs

    def all_runs(self, injected: Injected) -> dict[int, Run]:
        """Every run of the faulty session."""
        return {**self.runs, **injected.runs}

    def again(self) -> Draw:
        """The same draw with other chance."""
        return replace(self, attempt=self.attempt + 1)
