"""How long frames took, from their numbers at both ends."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from live.bodies import NUMBERS
from live.line import Sent
from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.errors import ShoecalError

LONGEST_NS = 1_000_000_000
"""What takes longer counts as lost."""


@dataclass
class Turn:
    """Frames that one chain got, one after the other.

    Attributes:
        chain: which.
        rate: of the frames [Hz].
        sent: the frames.
        latency_ms: (m,) of each frame, NaN where it is lost.
    """

    chain: str
    rate: float
    sent: list[Sent]
    latency_ms: FloatArray = field(default_factory=lambda: np.zeros(0))


def latencies_ms(sent: Sequence[Sent], at_ns: IntArray, numbers: IntArray) -> FloatArray:
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


def summary(turns: Sequence[Turn], rate: float) -> dict[str, float]:
    """A row of the table: median and 99th percentile of both chains, their ratios, frames lost."""
    found, lost = {"rate [Hz]": rate}, {}
    for chain, before in (("shoecal", ""), ("bare", "bare ")):
        each = np.concatenate(
            [turn.latency_ms for turn in turns if (turn.chain, turn.rate) == (chain, rate)]
        )
        heard = each[np.isfinite(each)]
        if not len(heard):
            raise ShoecalError(f"nothing was heard of the chain {chain} at {rate:g} Hz")
        lost[f"{before}lost"] = float(len(each) - len(heard))
        found[f"{before}median [ms]"] = float(np.median(heard))
        found[f"{before}99 % [ms]"] = float(np.percentile(heard, 99))
    for name in ("median", "99 %"):
        found[f"ratio, {name}"] = found[f"{name} [ms]"] / found[f"bare {name} [ms]"]
    return found | lost
