"""Detects broken cells from their readings alone, while they come.

A cell gives nothing, stands at an end of its converter's range, gives one value all the time
although the others' change, or although its own noise never let it rest before (`own_noise.py`: a
whole board may hang), or jumps all by itself: what happens to a foot is felt by more than one of
its cells. Readings of such cells are marked as the device marks them, so that no force is made of
them. What looks like a cell in order cannot be detected here: two cells that are swapped, one that
follows late, or one that is jammed but still noisy. A calibration and the watch for drift detect
those, by weight and CoM.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from shoecal_msgs.msg import ShoeVoltages

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.shoe.shoe import Shoe
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.inputs.joining import NEVER_NS, Joined
from shoecal_ros.inputs.own_noise import ALL, Cells, OwnNoise

FREEZE_S, FREEZE_FRAMES = 0.08, 8.0
"""Time constant of how often a reading changes: whichever is longer."""
LIVELY, FROZEN, THAWED = 0.8, 0.1, 0.5
"""Share of readings that differ from the ones before: of most cells that are well; of one that
has frozen, which it is until it has thawed."""
KNOWN_S = 5.0
"""Time constant of how often a cell's reading changes usually."""
NOISE_S = 1.0
"""Time constant of how much it changes."""
JUMP_NOISE, JUMP_SHARE = 10.0, 0.01
"""A jump is a change of so many usual ones, and of this share of the converter's range."""
ALONE = 5.0
"""The foot's other cells change by less than this part of it."""
JUMP_FRAMES = 3
"""Who has not come back from a jump by then has been loaded."""
JUMP_PERIOD_S = 0.05
"""Readings of a cell further apart show no jumps."""
SPIKE_S = 0.3
"""For so long after a spike its cell counts as broken."""
LEARN_S, LEARN_FRAMES = 0.04, 1000
"""Readings of so long a time, or so many, are learnt from at once."""
RESTART_S = 1.0
"""After a gap in the stamps all starts again."""

GOOD, SATURATED = ShoeVoltages.GOOD, ShoeVoltages.SATURATED
NO_DATA, FAULT = ShoeVoltages.NO_DATA, ShoeVoltages.FAULT
_CODES = {
    SATURATED: Code.CELL_SATURATED,
    NO_DATA: Code.CELL_SILENT,
    FAULT: Code.CELL_FAULT,
}
_FAULTS = {
    Code.CELL_SATURATED: "stands at an end of its range",
    Code.CELL_SILENT: "gives nothing",
    Code.CELL_FAULT: "is broken, says its device",
    Code.CELL_STUCK: "gives one value all the time",
    Code.CELL_LEAPS: "jumps by itself",
}
CURE = "check cable, clamp and board"


class CellWatch:
    """Watches joined readings.

    Attributes:
        spikes: (n,) how many each cell gave.
    """

    def __init__(self, shoe: Shoe) -> None:
        """Nothing has come.

        Args:
            shoe: names, feet and ranges of the channels.
        """
        count = len(shoe.names)
        self._names = shoe.names
        ends = np.array([[channel.lowest, channel.highest] for channel in shoe.channels])
        self._middle = ends.mean(axis=1)
        self._reach = (ends[:, 1] - ends[:, 0]) / 2.0
        self._least = JUMP_SHARE * 2.0 * self._reach
        near = (shoe.foot[:, None] == shoe.foot) & (shoe.torque[:, None] == shoe.torque)
        np.fill_diagonal(near, val=False)
        self._near = near.astype(np.float64)
        self.spikes = np.zeros(count, dtype=np.int64)
        self._status = np.zeros(count, dtype=np.uint8)
        self._calm = True
        self._stamp_ns: int | None = None
        self._restart(np.zeros(count))

    @property
    def noise(self) -> FloatArray:
        """(n,) standard deviation of the readings, in their unit, by their steps."""
        # Of a normal law, whose mean absolute difference is 2 / sqrt(pi) of it.
        return self._noise * (math.sqrt(math.pi) / 2.0)

    @property
    def findings(self) -> Mapping[str, Code]:
        """What is wrong with which cell by now."""
        found = {}
        for index in np.flatnonzero(self._status):
            status = min(int(self._status[index]), FAULT)
            code = _CODES[status]
            if status == FAULT and self._frozen[index]:
                code = Code.CELL_STUCK
            elif status == FAULT and (self._jumps[index] or self._spiky[index]):
                code = Code.CELL_LEAPS
            found[self._names[index]] = code
        return found

    @property
    def condition(self) -> Condition:
        """For diagnostics, with the cure, and how many spikes each cell gave."""
        found = self.findings
        spikes = zip(self._names, self.spikes.tolist(), strict=True)
        values = {f"spikes_of_{cell}": str(count) for cell, count in spikes if count}
        if found:
            reported = ", ".join(f"{cell} {_FAULTS[code]}" for cell, code in found.items())
            return Condition(Level.ERROR, f"{reported}: {CURE}", values, next(iter(found.values())))
        return Condition(Level.OK, "no cell is seen to be broken", values)

    def take(self, joined: Sequence[Joined]) -> list[Joined]:
        """Readings in order, those of broken cells marked; `learn` is to be called afterwards."""
        return [self._look(one) for one in joined]

    def learn(self) -> None:
        """Learn from what was taken how cells behave: this can wait until forces are published."""
        if len(self._taken) < 2:
            return
        elapsed_s = (self._taken[-1].stamp_ns - self._taken[0].stamp_ns) / 1e9
        if elapsed_s < LEARN_S and len(self._taken) < LEARN_FRAMES:
            return
        stamps = np.array([one.stamp_ns for one in self._taken])
        readings = np.array([one.readings for one in self._taken])
        new = np.array([one.new for one in self._taken])
        self._taken.clear()
        if new.all():
            self._learn(ALL, stamps, readings)
        else:
            # Each board's cells from its own readings: those of a slow one are among several.
            patterns, board = np.unique(new, axis=1, return_inverse=True)
            for index, own in enumerate(patterns.T):
                columns = np.flatnonzero(board.ravel() == index)
                if own.any():
                    self._learn(columns, stamps[own], readings[own][:, columns])
        self._bound = np.maximum(self._least, JUMP_NOISE * self._noise)
        self._look_for_frozen()

    def _learn(self, cells: Cells, stamps: IntArray, readings: FloatArray) -> None:
        """From (k, m) readings of some cells that were all new at each of k instants [ns]."""
        before_ns = self._learnt_ns[cells].min()
        if stamps[0] - before_ns <= RESTART_S * 1e9:
            stamps = np.concatenate([[before_ns], stamps])
            readings = np.concatenate([self._learnt[cells][None], readings])
        self._learnt_ns[cells], self._learnt[cells] = stamps[-1], readings[-1]
        if len(stamps) < 2:
            return
        elapsed_s = float(stamps[-1] - stamps[0]) / 1e9
        with np.errstate(invalid="ignore"):
            steps = np.diff(readings, axis=0)
        change = np.abs(steps)
        self._own_noise.take(steps, elapsed_s, cells)
        noise = self._noise[cells]
        usual = np.minimum(np.nan_to_num(change).mean(axis=0), 3.0 * noise + self._least[cells])
        self._noise[cells] += (1.0 - math.exp(-elapsed_s / NOISE_S)) * (usual - noise)
        # How often a reading changes, lately and usually.
        changing = np.mean(change != 0.0, axis=0)
        constant_s = max(FREEZE_S, FREEZE_FRAMES * elapsed_s / len(change))
        lately = 1.0 - math.exp(-elapsed_s / constant_s)
        self._changing[cells] += lately * (changing - self._changing[cells])
        # A converter with few bits repeats itself: that is how it is, unless it never does else.
        share = 1.0 - math.exp(-elapsed_s / KNOWN_S)
        self._usual_weight[cells] += share * (1.0 - self._usual_weight[cells])
        unchanged = self._frozen[cells]
        self._usual[cells] += np.where(unchanged, 0.0, share * (changing - self._usual[cells]))

    def _restart(self, readings: FloatArray) -> None:
        count = len(self._names)
        self._taken: list[Joined] = []
        self._changing = np.ones(count)
        self._usual = np.zeros(count)
        self._usual_weight = np.zeros(count)
        self._learnt = readings.copy()
        self._learnt_ns = np.full(count, NEVER_NS)
        self._own_noise = OwnNoise(count)
        self._noise = np.zeros(count)
        self._bound = self._least
        self._frozen = np.zeros(count, dtype=bool)
        self._jumps = np.zeros(count, dtype=np.int64)
        self._level = readings
        self._read_ns = np.zeros(count, dtype=np.int64)
        self._spiky_until_ns = np.zeros(count, dtype=np.int64)
        self._spiky = np.zeros(count, dtype=bool)

    def _look(self, one: Joined) -> Joined:
        readings, stamp_ns = one.readings, one.stamp_ns
        elapsed_s = math.inf if self._stamp_ns is None else (stamp_ns - self._stamp_ns) / 1e9
        self._stamp_ns = stamp_ns
        if not 0.0 < elapsed_s <= RESTART_S:
            self._restart(readings)
        self._taken.append(one)
        # Nearly always all is well, and readers of the forces are in a hurry.
        with np.errstate(invalid="ignore"):
            leaving = np.abs(readings - self._level)
        inside = np.abs(readings - self._middle) < self._reach
        if self._calm and (inside & (leaving <= self._bound)).all() and not one.status.any():
            self._level = readings
            marked = one
        else:
            marked = self._mark(one, inside, leaving)
        self._read_ns[one.new] = stamp_ns
        return marked

    def _mark(self, one: Joined, inside: BoolArray, leaving: FloatArray) -> Joined:
        """The readings with the status of each cell as it is seen; `inside`, `leaving` are (n,)."""
        known = np.isfinite(one.readings)
        self._look_for_jumps(one, np.where(known & np.isfinite(leaving), leaving, 0.0))
        status = one.status.copy()
        well = status == GOOD
        status[well & ~known] = NO_DATA
        status[well & known & ~inside] = SATURATED
        broken = self._frozen | (self._jumps > 0) | self._spiky
        status[(status == GOOD) & broken] = FAULT
        self._status = status
        self._calm = not (status.any() or broken.any())
        return replace(one, readings=np.where(known, one.readings, np.nan), status=status)

    def _look_for_frozen(self) -> None:
        """Against what the others do, or what the cell itself always did."""
        strange = (self._usual > THAWED * self._usual_weight) | (self._usual == 0.0)
        bound = np.where(self._frozen, THAWED, FROZEN)
        others_change = float(np.median(self._changing)) > LIVELY
        unlike_others = strange & (self._changing < bound) & others_change
        self._frozen = unlike_others | self._own_noise.ended
        self._calm = self._calm and not self._frozen.any()

    def _look_for_jumps(self, one: Joined, leaving: FloatArray) -> None:
        """From the last level that was believed; `leaving` is (n,).

        A slow board's reading goes with several of a fast one's: it has jumpt once.
        """
        far = leaving > self._bound
        back = (self._jumps > 0) & ~far & one.new
        self.spikes += back
        self._spiky_until_ns[back] = one.stamp_ns + round(1e9 * SPIKE_S)
        self._spiky = one.stamp_ns < self._spiky_until_ns
        near = self._near * one.new
        alone = (near * leaving).max(axis=1) * ALONE < leaving
        soon = one.stamp_ns - self._read_ns <= JUMP_PERIOD_S * 1e9
        begun = far & alone & near.any(axis=1) & soon
        away = far & ((self._jumps > 0) | begun)
        jumps = np.where(away, self._jumps + 1, 0)
        jumps[jumps > JUMP_FRAMES] = 0
        self._jumps = np.where(one.new, jumps, self._jumps)
        # What is no number leads from no level.
        level = np.where(np.isfinite(one.readings), one.readings, np.nan)
        self._level = np.where(self._jumps > 0, self._level, level)
