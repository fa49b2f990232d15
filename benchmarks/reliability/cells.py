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

from contextlib import nullcontext
from functools import partial

import numpy as np

from reliability.cells_live import LIVE, LiveCells
from reliability.cells_recorded import RECORDED, check_recorded
from reliability.live_world import World, live_tries
from reliability.row import Row

CELLS = 8
FAULTS = (*LIVE, *(fault for fault in RECORDED if fault not in LIVE))
WITHIN_S = 0.5


class Scene:
    """A calibrator beside a robot whose cells break, and recordings of robots whose cells broke."""

    def __init__(self, world: World) -> None:
        self.live = LiveCells(world)

    def attempt(self, number: int, rng: np.random.Generator) -> float:
        """Break a cell; time until it is reported live [s]. Faults come first: a share has all."""
        rest, fault_number = divmod(number, len(FAULTS))
        fault, cell, calibrating = (
            FAULTS[fault_number],
            (rest // 2 + fault_number) % CELLS,
            rest % 2,
        )
        if fault in RECORDED and (calibrating or fault not in LIVE):
            check_recorded(fault, cell, number)
        if fault not in LIVE:
            return 0.0
        with self.live.calibrating() if calibrating else nullcontext():
            return self.live.break_cell(fault, cell, rng)


ROW = Row(
    key="cells",
    fault="8 cells x off, stuck, saturated, NaN, spikes, slow, hung board, swapped, idle and while "
    "calibrating",
    holds="flagged within 0.5 s where it can be seen live, and never a calibration applied from it",
    tries=2 * CELLS * len(FAULTS),
    step=32,
    run=partial(live_tries, Scene, worst="{:.2f} s until reported", most=WITHIN_S),
)
