"""A robot that hangs, though it should stand: for a while within a run, or all along one.

Looked for before what else readings show, since channels that rest at their zeros look saturated.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.contact import moves
from shoecal_core.samples.lifting import TRANSIT_S
from shoecal_core.samples.stretches import lasting, unchanged, widened
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.events import leave_out_run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.result import Screening
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.screening.verdict import Finding, name_runs
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.vertical import at_least_load, both_carry_load
from shoecal_core.shoe.wrench import foot_wrenches

HANGS_SHARE = 0.1
"""Of the weight: by gains and offsets that are roughly known, a foot that hangs carries less."""
LEAST_S = 1.0
"""A robot that is lifted for a shorter time does not hang still."""
SETTLE_S = 0.15
"""Cut from both ends of that time: there the feet are just leaving or landing."""
LEAST_STANDING = 0.2
"""Of a run, that has to be left for it to be one in double support."""
STILL = 0.05
"""Of what a channel goes through in most runs, the most that it does in one all along which the
robot hangs."""
MOVES = 0.3
"""Of what the CoM goes through in most runs, the least that it does in such a run: it would not
stand still on its feet."""


def hung_runs(aligned: Mapping[int, Aligned], shoe: Shoe) -> dict[int, float]:
    """Runs in which no channel's readings change though the robot moves, if there are others.

    Args:
        aligned: runs in double support, by number.

    Returns:
        By run, what its CoM goes through [m].
    """
    if len(aligned) < 2:
        return {}
    through = {
        run: _through(blocks(one, shoe).readings[:, shoe.vertical]) for run, one in aligned.items()
    }
    path = {
        run: float(np.hypot(*_through(one.states.com[:, 0, :2]))) for run, one in aligned.items()
    }
    usual = np.median(list(through.values()), axis=0)
    moved = float(np.median(list(path.values())))
    return {
        run: path[run]
        for run, one in through.items()
        if (one < STILL * usual).all() and path[run] > MOVES * moved
    }


def _through(values: FloatArray) -> FloatArray:
    """(k,) ranges of values (T, k), without a twentieth at either end."""
    low, high = np.percentile(values, [5.0, 95.0], axis=0)
    return np.asarray(high - low)


def leave_out_hung(
    found: Screening, hung: Mapping[int, float], aligned: Mapping[int, Aligned]
) -> Screening:
    """What was found in the other runs, and that these hang."""
    if not hung:
        return found
    found = replace(
        found, samples={**found.samples, **{run: len(aligned[run].time) for run in hung}}
    )
    for run in hung:
        found = leave_out_run(found, run, aligned[run], Fault.HANGING)
    path = ", ".join(f"{1e3 * one:.0f} mm" for one in hung.values())
    text = (
        f"{name_runs(tuple(hung))}: no reading of either foot changes while the joints move the "
        f"CoM by {path}: the robot hung, or both feet's cables were off; left out. If it hung, say "
        "so (`motion: hanging` in a mapping), and its zeros are used"
    )
    return found.adding([Finding("WARN", text, Fault.HANGING)])


def both_hang(
    aligned: Mapping[int, Aligned], shoe: Shoe, weight: float, settings: CalibrationSettings
) -> dict[int, BoolArray]:
    """(T,) of each run in which the whole robot is lifted for a while: both feet hang still.

    Args:
        aligned: runs in double support, by number.
        weight: of robot and shoes [N].
    """
    low = {run: _both_low(shoe, one) for run, one in aligned.items()}
    low = {run: one for run, one in low.items() if one.any()}
    if not low:
        return {}
    # Gains and offsets by all else: no model holds for a robot that is carried.
    parts = {run: blocks(without(one, low.get(run)), shoe) for run, one in aligned.items()}
    parameters = Statics.of(shoe, parts, weight, settings).fit.parameters
    found = {}
    for run, mask in low.items():
        outputs = parameters.outputs(aligned[run].readings[mask])
        carried = np.median(foot_wrenches(shoe, outputs)[..., 0], axis=0)
        if (np.abs(carried) < HANGS_SHARE * weight).all():
            found[run] = mask
    return found


def without(aligned: Aligned, hanging: BoolArray | None) -> Aligned:
    """A run without the time (T,) in which the robot hangs, and is on its way there and back."""
    if hanging is None:
        return aligned
    return aligned.part(~widened(hanging, aligned.time, TRANSIT_S))


def _both_low(shoe: Shoe, aligned: Aligned) -> BoolArray:
    """(T,) both feet read their least, still, and for a while."""
    nowhere = np.zeros(len(aligned.time), dtype=bool)
    if both_carry_load(shoe, aligned.readings) is None:
        return nowhere
    low: BoolArray = np.all(at_least_load(shoe, aligned.readings), axis=1)
    low = ~widened(~low, aligned.time, SETTLE_S)
    low = lasting(low, aligned.time, LEAST_S)
    for part in unchanged(low.astype(np.int64)):
        if low[part[0]]:
            low[part] = not any(moves(shoe, aligned.readings, part, foot) for foot in (0, 1))
    return low if low.mean() <= 1.0 - LEAST_STANDING else nowhere
