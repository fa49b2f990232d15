"""Broken cells, idle and while calibrating.

Each of the eight cells is off, stuck, saturated, gives NaN or spikes, is slow, hangs with all
others of its board (its foot's, or all there are), or is swapped with another; 64 tries idle, 64
while a self-calibration is under way.

Live, a real calibrator beside a robot at 100 Hz (of which only messages exist; converters with 1 mV
of noise) must say within 0.5 s of the first spoilt frame which cell it is, no other, and call its
foot invalid: off, stuck, saturated, NaN, spikes of 2 N and more, slow (a new reading every 0.15 s),
a board that hangs (after five seconds in which its noise could be learnt). What cannot be seen
there, because the readings are those of cells in order: two cells that are swapped, a cell that
follows with a lag, one that is jammed but still noisy, spikes below 1 % of the converter's range.
While it calibrates, each fault is also put into the voltages of a recorded simulated session
(`population.py`: three robots, five double supports), a lag of 0.2 to 2 s among them, and the
session calibrated: refused or not applied (not PASS). Swapped cells are tried so both times. What
is spoilt can also be left out, and the rest of such a session applied, as a calibration without the
fault: "from it" is taken to mean that the fault shows in what is applied, and that it shows where
its CoP is a millimetre further from the simulated truth than without the fault.

The robot of the live tries never reaches its double support, so its self-calibration never comes to
a result: that none is applied from spoilt readings is shown by the recorded sessions alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from reliability.cells_live import LIVE, LiveCells
from reliability.cells_recorded import RECORDED, calibrate_spoilt
from reliability.live_world import live_world
from reliability.row import Progress, Result, Row

CELLS = 8
FAULTS = (*LIVE, *(fault for fault in RECORDED if fault not in LIVE))
TRIES = 2 * CELLS * len(FAULTS)
WITHIN_S = 0.5


@dataclass(frozen=True)
class Try:
    """One of the tries.

    Attributes:
        fault, cell: what breaks.
        calibrating: else idle.
    """

    fault: str
    cell: int
    calibrating: bool

    @staticmethod
    def of(index: int) -> Try:
        """The try of a number: faults come first, so that a share has them all."""
        fault, rest = index % len(FAULTS), index // len(FAULTS)
        return Try(FAULTS[fault], (rest // 2 + fault) % CELLS, bool(rest % 2))

    @property
    def name(self) -> str:
        return (
            f"cell {self.cell} {self.fault} {'while calibrating' if self.calibrating else 'idle'}"
        )


@dataclass(frozen=True)
class Outcome:
    """What came of one try.

    Attributes:
        tried: which.
        after: until it was told live [s]; 0 where it was not tried live.
        readings_s: the same by the stamps of the readings [s].
        wrong: what must not have happened, however long it took; empty where nothing has.
    """

    tried: Try
    after: float = 0.0
    readings_s: float = 0.0
    wrong: str = ""

    @property
    def failed(self) -> str:
        """In words, empty where it held."""
        late = f"told after {self.after:.2f} s" if self.after > WITHIN_S else ""
        return ", ".join(filter(None, (self.wrong, late)))


def break_live(tries: Mapping[int, Try], seed: int, *, calibrating: bool) -> list[Outcome]:
    """Break cells beside a real calibrator."""
    found = []
    with live_world() as world:
        cells = LiveCells(world)
        before = cells.in_force()
        if calibrating:
            cells.calibrate()
        for index, one in tries.items():
            told = cells.break_cell(one.fault, one.cell, np.random.default_rng([seed, index]))
            wrong = "" if told.alone else "another cell was told, too"
            if cells.in_force() != before:
                wrong = "another calibration came in force"
            found.append(Outcome(one, told.after, told.readings_s, wrong))
    return found


def break_recorded(index: int, seed: int) -> Outcome:
    """Calibrate from recordings of a broken cell."""
    one = Try.of(index)
    found = calibrate_spoilt(one.fault, one.cell, seed * TRIES + index)
    wrong = f"applied, {1e3 * found.worse:.1f} mm worse" if found.spoilt else ""
    return Outcome(one, wrong=wrong)


def run(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Tries first to first + count - 1."""
    tries = {index: Try.of(index) for index in range(first, first + count)}
    outcomes: list[Outcome] = []
    for calibrating in (False, True):
        live = {
            index: one
            for index, one in tries.items()
            if one.calibrating == calibrating and one.fault in LIVE
        }
        if live:
            outcomes += break_live(live, seed, calibrating=calibrating)
            progress(len(outcomes) // 2)
    for index, one in tries.items():
        if one.fault in RECORDED and (one.calibrating or one.fault not in LIVE):
            outcomes.append(break_recorded(index, seed))
            progress(min(len(outcomes), count))
    failures = {one.tried.name: one.failed for one in outcomes if one.failed}
    slowest = max(outcomes, key=lambda one: one.after)
    told = f"{slowest.after:.2f} s until told ({slowest.tried.name})"
    worst = "; ".join(f"{name}: {failed}" for name, failed in failures.items()) or told
    return Result(count, len(failures), worst[:300], slowest.after + len(failures))


ROW = Row(
    key="cells",
    fault="8 cells x off, stuck, saturated, NaN, spikes, slow, hung board, swapped, idle and while "
    "calibrating",
    holds="flagged within 0.5 s where it can be seen live, and never a calibration applied from it",
    tries=TRIES,
    step=32,
    run=run,
)
