"""A clock that was set while a session was recorded, as NTP does: one jump of the time offset.

The offset between joint angles and readings is found in pieces of each run. One level before some
moment and another one after it leave little of how far the pieces are apart.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.screening.clocks.time_offsets import CopTrack, late_of
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding

PIECES = 4
"""Of a run; in shorter ones offsets of slow motions are not known to 0.05 s."""
LEAST_PIECES = 2
"""On either side of a jump: one piece may be off by chance."""
LEAST_S = 0.08
"""Smaller jumps move the CoP by less than a sound calibration is off. Pieces of sound sessions are
apart by 0.02 s (median), single ones by 0.06."""
LEFT = 0.35
"""Of the sum of distances from one offset, what two of them leave at most: a jump of 0.3 s left
0.13; a clock that runs fast leaves half."""


@dataclass(frozen=True)
class ClockJump:
    """A jump of the time offset.

    Attributes:
        size: by which joint angles come later from then on [s].
        run: in which it is, or before which.
        time: in that run [s]; None where it lies before it.
        before: number of the last run before; None where there is none.
    """

    size: float
    run: int
    time: float | None
    before: int | None


def clock_jump(tracks: Mapping[int, CopTrack]) -> ClockJump | None:
    """The jump that explains how far offsets are apart; None without.

    Args:
        tracks: of each run, by the stamps as they are, in the order of recording.
    """
    pieces = [
        (run, CopTrack(track.time[part], track.measured[part], track.modelled[part]))
        for run, track in tracks.items()
        for part in np.array_split(np.arange(len(track.time)), PIECES)
        if len(part) > 1
    ]
    late = np.array([late_of([piece]) for _, piece in pieces])
    splits = range(LEAST_PIECES, len(late) - LEAST_PIECES + 1)
    if not splits:
        return None
    left = [_apart(late[:at]) + _apart(late[at:]) for at in splits]
    at = splits[int(np.argmin(left))]
    size = float(np.median(late[at:]) - np.median(late[:at]))
    if abs(size) < LEAST_S or min(left) > LEFT * _apart(late):
        return None
    run, piece = pieces[at]
    before = pieces[at - 1][0]
    if before == run:
        return ClockJump(size, run, float(piece.time[0]), None)
    return ClockJump(size, run, None, before)


def _apart(late: FloatArray) -> float:
    """Sum of distances from the median of offsets (k,)."""
    return float(np.abs(late - np.median(late)).sum())


def describe_clock_jump(found: ClockJump | None) -> list[Finding]:
    """A clock that was set, which no constant offset puts right."""
    if found is None:
        return []
    where = (
        f"between runs {found.before} and {found.run}"
        if found.time is None
        else f"in run {found.run} (at about {found.time:.0f} s)"
    )
    names = ("joint angles", "readings")
    later, sooner = names if found.size > 0.0 else names[::-1]
    return [
        Finding(
            "FAIL",
            f"{later} come {abs(found.size):.2f} s later against the {sooner} from a moment "
            f"{where} on: a clock was set (NTP, a board that started again); stop clock steps "
            "while you record, or stamp both by one clock, and record again, or use runs of one "
            "side alone (--train, --test)",
            Fault.LATE,
        )
    ]
