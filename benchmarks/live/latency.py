"""How long frames took, from their numbers at both ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from live.bodies import NUMBERS
from live.line import Sent
from shoecal_core.errors import ShoecalError

FloatArray = NDArray[np.float64]
LONGEST_NS = 1_000_000_000
"""What takes longer counts as lost."""


@dataclass
class Turn:
    """Frames that one chain got, one after the other.

    Attributes:
        chain: which.
        activity: what went on meanwhile.
        rate: of the frames [Hz].
        sent: the frames.
        latency_ms: (m,) of each frame, NaN where it is lost.
    """

    chain: str
    activity: str
    rate: float
    sent: list[Sent]
    latency_ms: FloatArray = field(default_factory=lambda: np.zeros(0))


def latencies_ms(
    sent: Sequence[Sent], at_ns: NDArray[np.int64], numbers: NDArray[np.int64]
) -> FloatArray:
    """(m,) time from each frame's writing to its hearing, NaN where it was not heard.

    Args:
        sent: m frames.
        at_ns: (k,) when something was heard, growing [ns].
        numbers: (k,) of the frames that it came from, modulo NUMBERS.
    """
    latency = np.full(len(sent), np.nan)
    for index, one in enumerate(sent):
        begin, end = np.searchsorted(at_ns, [one.at_ns, one.at_ns + LONGEST_NS])
        found = np.flatnonzero(numbers[begin:end] == one.number % NUMBERS)
        if len(found):
            latency[index] = (at_ns[begin + found[0]] - one.at_ns) / 1e6
    return latency


def summary(turns: Sequence[Turn], activity: str, rate: float) -> dict[str, float]:
    """Median and 99th percentile of both chains [ms], frames lost, and the ratios."""
    found: dict[str, float] = {}
    for chain in ("shoecal", "bare"):
        each = np.concatenate(
            [
                turn.latency_ms
                for turn in turns
                if (turn.chain, turn.activity, turn.rate) == (chain, activity, rate)
            ]
        )
        heard = each[np.isfinite(each)]
        if not len(heard):
            raise ShoecalError(f"nothing was heard of the chain {chain} ({activity}, {rate:g} Hz)")
        found[f"{chain}_lost"] = float(len(each) - len(heard))
        found[f"{chain}_median_ms"] = float(np.median(heard))
        found[f"{chain}_p99_ms"] = float(np.percentile(heard, 99))
    for name in ("median", "p99"):
        found[f"vs_relay_{name}"] = found[f"shoecal_{name}_ms"] / found[f"bare_{name}_ms"]
    return found


def disturbance(busy: Mapping[str, float], quiet: Mapping[str, float], figure: str) -> float:
    """A figure while something goes on over the same while nothing does.

    Args:
        busy, quiet: summaries.
        figure: for example shoecal_p99.
    """
    return busy[f"{figure}_ms"] / quiet[f"{figure}_ms"]
