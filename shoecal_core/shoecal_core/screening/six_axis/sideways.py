"""Sideways axes of six-axis sensors that are reversed, or at each other's place.

While a robot moves slowly on both feet, what the floor pushes one foot sideways it pushes the other
one back: both forces cancel, up to the mass times its CoM's acceleration and to zeros.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.filters import typical_period
from shoecal_core.samples.stretches import lasting, stretches
from shoecal_core.screening.blocks import block_size, in_blocks
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.loads.pulled import JOIN_S, LASTS_S, Pull, what_lasts
from shoecal_core.screening.verdict import Finding
from shoecal_core.shoe.shoe import FEET, Shoe

AXES = ("fx", "fy")
CANCELS = 0.25
"""Of the median square that does not cancel, the most that other axes may leave."""
ALIKE = 2.0
"""Axes that leave so many times the least explain it as well."""
SIGNS = tuple(product((1.0, -1.0), repeat=2))
"""Of two axes."""
PUSHED_SHARE, UNLIKE = 0.04, 4.0
"""Part of the weight by which both feet's forces do not cancel while a hand pushes, and times what
they leave in other runs: six-axis sensors of simulated robots leave 0.4 %, of an iCub 1.5 to 3.7 %
alike in all its runs."""
FAR = 3.0
"""What does not cancel is that many times the mass times the CoM's acceleration, or more."""


@dataclass(frozen=True)
class SidewaysFault:
    """Axes that would cancel: each way to wire them that does so with the fewest changes.

    Attributes:
        ways: of each, the changes in words, such as `left/fx reversed`.
    """

    ways: tuple[tuple[str, ...], ...]


def sideways_fault(
    shoe: Shoe, aligned: Mapping[int, Aligned], weight: float
) -> SidewaysFault | None:
    """Whether the feet's sideways forces cancel only with other signs or places of their axes.

    Args:
        aligned: slow runs with both feet on the floor, by number.
        weight: of robot and shoes [N].
    """
    pairs = list(_pairs(shoe, aligned).values())
    if not pairs:
        return None
    force, turn, com = (
        np.concatenate(parts)
        for parts in zip(*((one.force, one.turn, one.acceleration) for one in pairs), strict=True)
    )
    ways = [_signed(order, signs) for order in ((0, 1), (1, 0)) for signs in SIGNS]
    left = {}
    for of_left, of_right in product(range(len(ways)), repeat=2):
        right = np.einsum("bij,jk,bk->bi", turn, ways[of_right], force[:, 1])
        left[of_left, of_right] = _usual(force[:, 0] @ ways[of_left].T + right)
    least, push = min(left.values()), _usual(weight / GRAVITY * com)
    if least > CANCELS * left[0, 0] or left[0, 0] < FAR**2 * push:
        return None
    good = [
        tuple(f"{FEET[foot]}/{change}" for foot in (0, 1) for change in _changes(ways[pair[foot]]))
        for pair, one in left.items()
        if one <= ALIKE * least
    ]
    fewest = min(map(len, good))
    return SidewaysFault(tuple(way for way in good if len(way) == fewest))


def sideways_pulls(shoe: Shoe, aligned: Mapping[int, Aligned], weight: float) -> list[Pull]:
    """Runs in which a force from outside pushed the robot sideways for a while.

    Args:
        aligned: runs with both feet on the floor, by number.
        weight: of robot and shoes [N].
    """
    pairs = _pairs(shoe, aligned)
    sums = {run: one.sum() for run, one in pairs.items()}
    largest = {run: float(np.abs(one).max()) for run, one in sums.items()}
    found = []
    for run, force in sums.items():
        others = [largest[number] for number in sums if number != run]
        if not others:
            continue
        limit = max(PUSHED_SHARE * weight, UNLIKE * float(np.median(others)))
        size = np.linalg.norm(force, axis=1)
        beyond = lasting(size > limit, pairs[run].time, LASTS_S)
        if beyond.any():
            times = stretches(beyond, pairs[run].time, JOIN_S)
            found.append(Pull(run, float(size[beyond].max()), times, sideways=True))
    return found


@dataclass(frozen=True)
class _Pair:
    """Sideways forces of both feet in the B blocks of one run.

    Attributes:
        time: (B,) since the run's start [s].
        force: (B, 2, 2) of each foot in its own axes, less the run's median [N].
        turn: (B, 2, 2) of the right foot's axes into the left one's.
        acceleration: (B, 2) of the CoM by the joint angles [m/s^2].
    """

    time: FloatArray
    force: FloatArray
    turn: FloatArray
    acceleration: FloatArray

    def sum(self) -> FloatArray:
        """(B, 2) of both feet, without what is over soon and what stays [N]."""
        both = self.force[:, 0] + np.einsum("bij,bj->bi", self.turn, self.force[:, 1])
        period = float(np.median(np.diff(self.time))) if len(self.time) > 1 else LASTS_S
        calm = what_lasts(both, period)
        return calm - np.median(calm, axis=0)


def _pairs(shoe: Shoe, aligned: Mapping[int, Aligned]) -> dict[int, _Pair]:
    """Of each run; none where a foot has no sideways axes."""
    names = [f"{foot}/{axis}" for foot in FEET for axis in AXES]
    if not set(names) <= set(shoe.names):
        return {}
    channels = [shoe.index(name) for name in names]
    gain = np.array([shoe.channels[i].rough_gain for i in channels])
    found = {}
    for run, one in aligned.items():
        size = block_size(one.time)
        shown = np.median(in_blocks(one.readings[:, channels], size), axis=1) * gain
        com = in_blocks(one.states.com[:, 0, :2], size).mean(axis=1)
        period = size * typical_period(one.time)
        found[run] = _Pair(
            in_blocks(one.time, size).mean(axis=1),
            (shown - np.median(shown, axis=0)).reshape(-1, 2, 2),
            in_blocks(one.states.rotation[:, :2, :2], size).mean(axis=1),
            np.gradient(np.gradient(com, period, axis=0), period, axis=0),
        )
    return found


def _usual(forces: FloatArray) -> float:
    """Median square of forces (B, 2): while a hand holds the robot, nothing cancels."""
    return float(np.median((forces**2).sum(axis=1)))


def _signed(order: tuple[int, int], signs: tuple[float, ...]) -> FloatArray:
    """(2, 2) what makes the right axes of what is recorded."""
    turn = np.zeros((2, 2))
    turn[(0, 1), order] = signs
    return turn


def _changes(way: FloatArray) -> list[str]:
    """What is wrong of a foot's axes, in words."""
    turned = [f"{AXES[row]} reversed" for row in (0, 1) if way[row].sum() < 0.0]
    return turned + (["fx and fy exchanged"] if way[0, 0] == 0.0 else [])


def describe_sideways(found: SidewaysFault | None) -> list[Finding]:
    """Sideways axes of six-axis sensors that do not cancel as they are."""
    if found is None:
        return []
    ways = ", or ".join(" and ".join(way) for way in found.ways)
    return [
        Finding(
            "FAIL",
            "the feet's sideways forces do not cancel while the robot stands on both; they would "
            f"with {ways}: push the standing robot forward and to the left to see, then correct "
            "the axes' polarity or names in the shoe file, or the sensor's frame at its driver",
            Fault.INVERTED,
        )
    ]
