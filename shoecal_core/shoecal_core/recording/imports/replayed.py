"""Two series of stamps in one topic: an old bag was played while a new one was recorded."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

APART_S = 1.0
"""Between the delays of both series; messages of one sender are not so late."""
DAY_S = 86400.0
TURNS = 10
"""Changes from one series to the other: a clock that is set steps once or twice."""


def replayed(delays: Sequence[float]) -> float | None:
    """How far apart two series are that come in turns [s]; None where there is one.

    Args:
        delays: of each message, in the order of receipt: receipt less stamp [s].
    """
    delay = np.array(delays)
    if len(delay) <= TURNS:
        return None
    order = np.sort(delay)
    at = int(np.argmax(np.diff(order)))
    late = delay > order[at]
    if order[at + 1] - order[at] < APART_S or np.count_nonzero(np.diff(late)) < TURNS:
        return None
    return float(np.median(delay[late]) - np.median(delay[~late]))


def describe_replayed(apart_s: float) -> str:
    """What such a topic holds, with its cure."""
    apart = f"{apart_s / DAY_S:.1f} days" if apart_s > DAY_S else f"{apart_s:.1f} s"
    return (
        f"holds two series of messages in turns, whose stamps are {apart} apart: was an old bag "
        "played onto this topic while the new one was recorded, or do two machines send on it "
        "whose clocks differ? Stop one of them, or set their clocks, and record again"
    )
