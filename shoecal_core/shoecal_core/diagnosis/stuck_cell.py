"""A cell that gets stuck while others go on, for good or for a while: found by readings alone.

What screening finds, a diagnosis finds: a cell whose readings follow from the others' by one law,
and do not for some time. What it should have shown then follows from that law: with that in its
place, gains are fitted and all else is looked for as if it had never got stuck.

A cell that is stuck from the first sample to the last, or nearly so, has no such law. In its place
comes what the weight leaves for it: the other cells' gains g and offsets o are those that fit the
modelled wrench in all that does not depend on the force of the dead cell d, and its own force is

    f_d = F - sum_(i != d) (g_i v_i + o_i).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.diagnosis.result import Cause, Size
from shoecal_core.diagnosis.shrink import shrink
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.effects import places
from shoecal_core.error_sources.signals import COP
from shoecal_core.samples.samples import Samples
from shoecal_core.samples.stretches import Stretch
from shoecal_core.screening.blocks import reading_blocks
from shoecal_core.screening.cells.saturated import ended
from shoecal_core.screening.cells.unresponsive import away, dead, stuck_channels
from shoecal_core.shoe.wrench import at_cop, by_parameters, columns_in_left, combined, weight_below

MOST_LEFT = 0.5
"""Of the mean square of the CoP's error, what a right correction leaves at most: less than a
twentieth in simulations, and one of another cell of the same foot four fifths or more."""
SHARE_ERROR = 0.05
"""How far the share that stays may be off, as an interval's half width."""


@dataclass(frozen=True)
class StuckChannel:
    """A cell that got stuck.

    Attributes:
        channel: which.
        time: when it first got stuck, since the session began [s].
        stretches: of time in which the law says what it should have shown [s]; all, where it hardly
            ever moved.
        step: from the block before it got stuck to the next [s].
        share: of its signal that stays.
        law: (1 + n,) by which it follows all channels otherwise, a constant first.
    """

    channel: int
    time: float
    stretches: tuple[Stretch, ...]
    step: float
    share: float
    law: FloatArray

    def cause(self, before: Workspace, corrected: Workspace) -> Cause:
        """What it is, by what is left with the readings as they came and as corrected."""
        place = (corrected.signal_model.samples.shoe.names[self.channel],)
        return Cause(
            effect="stuck_cell",
            group="load_cell",
            location=place,
            probability=1.0,
            size={
                "share": Size(self.share, "", _around(self.share, SHARE_ERROR)),
                "time": Size(self.time, "s", _around(self.time, self.step)),
            },
            run=None,
            shrink=shrink(corrected, before.explained(None)[0], corrected.explained(None)[0]),
            hidden_cop_mm=0.0,
        )

    def explains(self, before: Workspace, corrected: Workspace) -> bool:
        """Whether the CoP is much nearer to the model's while it was stuck, or as near as that of a
        robot within tolerance: in place of another cell of the foot it would correct the GRF alone.
        """
        still = self._stuck(corrected.signal_model.samples.clock)
        there = still & before.signal_model.mask[:, COP].all(axis=1)
        there &= corrected.signal_model.mask[:, COP].all(axis=1)
        first, then = (
            float((one.explained(None)[0][there][:, COP] ** 2).sum()) for one in (before, corrected)
        )
        usual = np.count_nonzero(there) * float((corrected.floor[COP] ** 2).sum())
        return then <= max(MOST_LEFT * first, usual)

    def corrected(self, samples: Samples) -> Samples:
        """The session as the cell would have shown it."""
        tracks = tuple(
            replace(one, readings=self._corrected(one.readings, one.start + one.time))
            for one in samples.tracks
        )
        readings = self._corrected(samples.readings, samples.clock)
        return replace(samples, tracks=tracks, readings=readings)

    def _corrected(self, readings: FloatArray, clock: FloatArray) -> FloatArray:
        corrected = readings.copy()
        still = self._stuck(clock)
        corrected[still, self.channel] = self.law[0] + readings[still] @ self.law[1:]
        return corrected

    def _stuck(self, clock: FloatArray) -> BoolArray:
        """(T,) when it was."""
        still: BoolArray = np.any(
            [(clock >= start) & (clock < end) for start, end in self.stretches], axis=0
        )
        return still


def stuck_cell(samples: Samples) -> StuckChannel | None:
    """The cell that most clearly was stuck, if one was."""
    tracks = sorted(samples.tracks, key=lambda one: one.start)
    runs = {one.run: reading_blocks(one.time, one.readings) for one in tracks}
    clock = np.concatenate([one.start + runs[one.run].time for one in tracks])
    # Halfway between blocks, the first one at the first sample.
    start = tracks[0].start + float(tracks[0].time[0])
    moments = np.concatenate(([start], 0.5 * (clock[1:] + clock[:-1]), [np.inf]))
    cells = places.vertical(samples.shoe).tolist()
    silent = dead(samples.shoe, runs)
    for channel in silent:
        if channel in cells and (law := _law_by_weight(samples, channel, silent)) is not None:
            first = _longest(away(samples.shoe, runs, channel))
            step = _step(clock, first)
            return StuckChannel(channel, float(moments[first]), ((start, np.inf),), step, 1.0, law)
    found = stuck_channels(samples.shoe, runs, silent)
    at_end = {one.channel for one in ended(runs, found)}
    for stuck in found:
        if stuck.channel in cells and stuck.channel not in at_end:
            edges = np.flatnonzero(np.diff(np.concatenate(([False], stuck.still, [False]))))
            stretches = tuple(
                (float(moments[first]), float(moments[end])) for first, end in edges.reshape(-1, 2)
            )
            step = _step(clock, int(edges[0]))
            return StuckChannel(
                stuck.channel, stretches[0][0], stretches, step, stuck.share, stuck.law
            )
    return None


def _longest(away: BoolArray) -> int:
    """First block of the longest time (B,) in which a channel is where it mostly is."""
    edges = np.concatenate(([-1], np.flatnonzero(away), [len(away)]))
    return int(edges[np.argmax(np.diff(edges))]) + 1


def _step(clock: FloatArray, first: int) -> float:
    """From the block before one to it, from the first to the second one for the first [s]."""
    return float(np.diff(clock)[max(first, 1) - 1])


def _law_by_weight(samples: Samples, dead_channel: int, silent: Sequence[int]) -> FloatArray | None:
    """(1 + n,) what the weight leaves for a dead cell; None where no sample is on both feet.

    In its own unit, as if its gain were like the others'. Moments about the dead cell do not depend
    on its force: from them come the gains of the others.
    """
    shoe = samples.shoe
    below = weight_below(shoe)
    others = [one for one in range(len(shoe.names)) if one not in silent]
    rows, targets, rest = [], [], []
    for segment in np.unique(samples.segment[samples.both]):
        part = (samples.segment == segment) & samples.both
        support = samples.supports[int(segment)]
        columns = columns_in_left(shoe, support)
        wrench = at_cop(samples.force[part], samples.cop[part]) - combined(below, support)
        arm = columns[dead_channel, 1:] / columns[dead_channel, 0]
        slopes = columns[others, 1:] - columns[others, :1] * arm
        readings = samples.readings[part][:, others]
        rows.append(by_parameters(slopes.T, readings).reshape(-1, 2 * len(others)))
        targets.append((wrench[:, 1:] - wrench[:, :1] * arm).ravel())
        rest.append(wrench[:, 0])
    if not rows:
        return None
    matrix = np.concatenate(rows)
    size = np.maximum(np.linalg.norm(matrix, axis=0), 1e-12)
    solution = np.linalg.lstsq(matrix / size, np.concatenate(targets), rcond=1e-6)[0] / size
    gain, offset = np.split(solution * np.tile(shoe.columns[others, 0], 2), 2)
    law = np.zeros(1 + len(shoe.names))
    law[0] = float(np.mean(np.concatenate(rest))) - float(offset.sum())
    law[1 + np.array(others)] = -gain
    unit = float(np.median(np.abs(gain)))
    law /= shoe.columns[dead_channel, 0] * unit * (shoe.polarity[dead_channel] or 1)
    return law


def _around(value: float, either: float) -> tuple[float, float]:
    return value - either, value + either
