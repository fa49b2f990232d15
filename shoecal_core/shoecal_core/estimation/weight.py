"""What the robot weighs by the data sheets of its own sensors.

Over a recording that starts and ends at rest the floor carries the weight on average, whatever the
robot does in between, so no model of its dynamics is needed: only the sum of both feet's vertical
forces above their zeros. A wrong weight in the robot file looks like a common error of all gains.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.samples.zeros import Zero, data_sheet
from shoecal_core.shoe.shoe import FEET, Shoe


@dataclass(frozen=True)
class Weighed:
    """The weight by data sheets.

    Attributes:
        kg: of robot and shoes.
        ci95: interval of it, if the data sheets' vertical gains hold [kg].
        runs: numbers of the runs that it was taken from.
    """

    kg: float
    ci95: tuple[float, float]
    runs: tuple[int, ...]

    def to_json(self) -> dict[str, object]:
        """For result files."""
        return {"data_sheet_kg": self.kg, "ci95": list(self.ci95), "runs": list(self.runs)}


def weigh(shoe: Shoe, readings: Mapping[int, FloatArray], zeros: Sequence[Zero]) -> Weighed | None:
    """The weight over the runs in which both feet hang at times; None without data sheets or any.

    Args:
        shoe: of the readings.
        readings: (T, n) raw, of each whole run.
        zeros: of the runs.
    """
    laws = [data_sheet(shoe, foot) for foot in range(len(FEET))]
    each, unsure = {}, []
    for run, values in readings.items():
        own = {zero.foot: zero for zero in zeros if zero.run == run}
        if len(own) < len(FEET) or None in laws:
            continue
        total, variance = 0.0, 0.0
        for foot, law in enumerate(laws):
            assert law is not None
            zero, std = own[foot].force(shoe, law)
            columns = np.where(shoe.foot == foot, shoe.columns[:, 0], 0.0)
            below = GRAVITY * shoe.plates[foot].mass_below
            total += float((law.outputs(values) @ columns).mean()) + below - zero
            variance += std**2
        each[run] = total / GRAVITY
        unsure.append(np.sqrt(variance) / GRAVITY)
    if not each:
        return None
    found = np.array(list(each.values()))
    # Zeros may be wrong alike in every run: that part does not shrink with their number.
    half = 1.96 * float(np.median(unsure))
    if len(found) > 1:
        spread = float(found.std(ddof=1)) / np.sqrt(len(found))
        half = float(np.hypot(half, stdtrit(len(found) - 1, 0.975) * spread))
    kg = float(found.mean())
    return Weighed(kg, (kg - half, kg + half), tuple(each))
