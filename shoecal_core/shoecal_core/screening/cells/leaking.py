"""Does one cell's signal leak into the next one that is read, as behind a hurried multiplexer?

A converter that reads cell after cell through a multiplexer keeps a share of the signal before
where its input has not settled. Every cell of a foot then shows a share of the one that is read
before it. That is undone for the orders in which cells may be read; the share that makes the
readings fit much better is the leak.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import permutations, product

import numpy as np
from scipy.optimize import minimize_scalar

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET, Shoe

TRIED = (0.08, 0.16, 0.24)
"""Shares by which orders are compared; with the right one each of them fits better, up to nearly
twice the true share."""
MOST_SHARE = 0.45
"""From half on it is the cell before that is read."""
LEAST_SHARE = 0.08
"""Smaller leaks are left to the fit: 0.08 moves the CoP of a NAO by 5 mm, of Wren by 1.7 mm (RMS),
0.06 of Wren by 1.2 mm, as much as is stated."""
LEFT = 0.6
"""Of the sum of squares, what undoing the leak leaves at most: 0.15 leaves 0.18. Eleven sound
sessions keep 0.85 and more, eight made-up ones 0.83, one cell that is held by the shoe 0.94."""
LEAST_GAIN = 7.0
"""By which the sum of squares has to fall; of sound sessions it falls by 2.6 at most."""
SURE_STDS = 5.0
"""A leak is its share off zero by so many of its standard deviations; a ground that all cells of a
foot share looks like one of 0.09 with 0.025."""
LONGEST_BLOCK_S = 1.0
"""Blocks of readings whose stamps come in bunches are longer, and too few to show a leak."""
ALL_ORDERS = 4
"""Cells of a foot up to which every order is tried; of more, that of the shoe file and its
reverse."""
STEP = 0.02
"""Of the share, in which it is seen how fast the sum of squares rises around the best one."""

Chains = tuple[tuple[int, ...], ...]
"""Channels in the order in which they are read, round and round; one chain a multiplexer."""


@dataclass(frozen=True)
class Leak:
    """Cells that keep a share of the cell read before.

    Attributes:
        chains: of channels, in the order in which they are read.
        share: of the reading before.
        std: its standard deviation.
    """

    chains: Chains
    share: float
    std: float


def leaking(statics: Statics) -> Leak | None:
    """The leak that explains most of what does not fit; None without, and for other sensors.

    A single bad run may fit a leak better: it must hold without any one of the runs, too. Only
    cells that measure the vertical force alone are judged; others may have crosstalk.
    """
    shoe, runs = statics.shoe, statics.parts
    if not shoe.vertical.all() or max(one.period for one in runs.values()) > LONGEST_BLOCK_S:
        return None

    def cost(chains: Chains, share: float, without: int | None = None) -> float:
        undo = np.linalg.inv(mixing(chains, len(shoe.names), share)).T
        kept = statics if without is None else statics.without({without})
        return kept.changed(lambda one: replace(one, readings=one.readings @ undo)).fit.cost

    plain = cost((), 0.0)
    if plain < LEAST_GAIN:
        return None
    _, chains = min((cost(chains, share), chains) for chains in orders(shoe) for share in TRIED)
    best = minimize_scalar(
        lambda share: cost(chains, float(share)), bounds=(0.0, MOST_SHARE), method="bounded"
    )
    left, share = float(best.fun), float(best.x)
    if share < LEAST_SHARE or left > min(LEFT * plain, plain - LEAST_GAIN):
        return None
    if any(cost(chains, share, run) > LEFT * cost((), 0.0, run) for run in runs):
        return None
    std = _std(lambda at: cost(chains, at), share)
    return Leak(chains, share, std) if share > SURE_STDS * std else None


def orders(shoe: Shoe) -> Iterator[Chains]:
    """Ways in which cells may be read: by a multiplexer for each foot, for one of them or both, or
    one for both feet together.
    """
    feet = [shoe.of_foot(foot) for foot in (0, 1)]
    for left, right in product(*([(), *_rounds(cells)] for cells in feet)):
        if left or right:
            yield tuple(chain for chain in (left, right) if chain)
    together = tuple(range(len(shoe.names)))
    yield (together,)
    yield (together[::-1],)


def _rounds(cells: IntArray) -> list[tuple[int, ...]]:
    """Orders of one foot's cells, round and round."""
    first, *others = cells.tolist()
    if not others:
        return []
    if len(cells) > ALL_ORDERS:
        return [(first, *others), (first, *others[::-1])]
    return [(first, *rest) for rest in permutations(others)]


def mixing(chains: Chains, count: int, share: float) -> FloatArray:
    """(n, n) what readings of n cells become, each with a share of the one read before it."""
    mixed = np.eye(count)
    for chain in chains:
        for at, channel in enumerate(chain):
            mixed[channel, channel] -= share
            mixed[channel, chain[at - 1]] += share
    return mixed


def _std(cost: Callable[[float], float], share: float) -> float:
    """How well a share at the least cost is known, by how fast the cost rises around it."""
    curved = (cost(share + STEP) - 2.0 * cost(share) + cost(share - STEP)) / STEP**2
    return float(np.sqrt(2.0 / max(curved, 2.0)))


def describe_leaking(shoe: Shoe, found: Leak | None) -> list[Finding]:
    """Cells that keep a share of what was read before them."""
    if found is None:
        return []
    feet = {int(shoe.foot[channel]) for chain in found.chains for channel in chain}
    where = "both feet" if len(feet) == 2 else f"the {FEET[feet.pop()]} foot"
    listed = "; ".join(", ".join(shoe.names[one] for one in chain) for chain in found.chains)
    return [
        Finding(
            "FAIL",
            f"each cell of {where} reads {100.0 * found.share:.0f} +- "
            f"{max(1.0, 200.0 * found.std):.0f} % of the cell before it, round and round "
            f"({listed}): the converter's input has not settled when it is read (multiplexer); "
            "read every channel twice and throw the first away, or scan slower, then record again",
            Fault.LEAKING,
        )
    ]
