"""Readings that wrap: signed numbers of a converter that are read as if they had no sign.

What should pass below zero comes from the top of the range instead. Two samples in a row then
differ by one and the same number, whatever the load, and with that number taken off, all that came
from the top goes on where the channel was.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.run import Run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import Shoe

USUAL = 0.9
"""Quantile of a channel's changes that counts as a usual one."""
CLOSE = 6.0
"""Usual changes by which a channel may move within the sample in which it wraps."""
LEAST_SPAN = 2.0
"""Of what the channel goes through once it goes on, that it jumps by at least: a converter has
room to spare on both sides. A contact that opens jumps to one value."""
LEAST_MOVES = 5.0
"""Usual changes that a channel goes through on either side, at least: else one side is a value
that stands for none."""
CROSSINGS = 3
"""Jumps, at least."""


@dataclass(frozen=True)
class Wrapped:
    """A channel that wraps.

    Attributes:
        channel: index.
        span: what it jumps by, in its unit.
        crossings: how often.
    """

    channel: int
    span: float
    crossings: int


def wrapped(runs: Mapping[int, Run]) -> list[Wrapped]:
    """Channels of signed numbers that are read without their sign."""
    values = [run.readings.value for run in runs.values()]
    found = []
    for channel in range(values[0].shape[1] if values else 0):
        parts = [one[np.isfinite(one[:, channel]), channel] for one in values]
        span, crossings = _span([part for part in parts if len(part) > 1])
        if crossings >= CROSSINGS:
            found.append(Wrapped(channel, span, crossings))
    return found


def _span(parts: Sequence[FloatArray]) -> tuple[float, int]:
    """What a channel's values, each run's (T,), jump by, and how often; 0 times where that is no
    wrap.
    """
    if not parts:
        return 0.0, 0
    ordered = np.sort(np.concatenate(parts))
    widest = int(np.argmax(np.diff(ordered)))
    low, high = ordered[: widest + 1], ordered[widest + 1 :]
    middle = 0.5 * (low[-1] + high[0])
    steps = np.concatenate([np.diff(one) for one in parts])
    across = np.concatenate([np.diff((one > middle).astype(int)) != 0 for one in parts])
    if not across.any() or across.all():
        return 0.0, 0
    usual = float(np.quantile(np.abs(steps[~across]), USUAL))
    span = float(np.median(np.abs(steps[across])))
    # What came from the top is below zero.
    whole = float(max(low[-1], high[-1] - span) - min(low[0], high[0] - span))
    goes_on = bool((np.abs(np.abs(steps[across]) - span) <= CLOSE * usual).all())
    moves = min(np.ptp(low), np.ptp(high)) > LEAST_MOVES * usual
    # A spike of one height begins and ends anywhere.
    below = bool(high[-1] - span <= low[0] + CLOSE * usual)
    if not (goes_on and moves and below and span > LEAST_SPAN * whole):
        return 0.0, 0
    return span, int(across.sum())


def describe_wrapped(shoe: Shoe, found: Sequence[Wrapped]) -> list[Finding]:
    """Channels that wrap, those by the same number together."""
    if not found:
        return []
    names = ", ".join(shoe.names[one.channel] for one in found)
    span = float(np.median([one.span for one in found]))
    many = len(found) > 1
    return [
        Finding(
            "FAIL",
            f"{names} jump{'' if many else 's'} by {span:.6g} {shoe.unit} from one sample to the "
            f"next, {sum(one.crossings for one in found)} times, and without that "
            f"{'they go' if many else 'it goes'} on as before: signed numbers are read without "
            f"their sign, so what is below zero comes from the top; take {span:.6g} {shoe.unit} "
            "off readings from there on, or extend the sign in the firmware (24 bits: from 2^23 "
            "on, less 2^24), and import or record again",
            Fault.CODES,
        )
    ]
