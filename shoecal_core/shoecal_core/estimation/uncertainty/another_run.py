"""What recording one of the training runs once more would win."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.joint_fit import JointFit
from shoecal_core.estimation.uncertainty.expected import ErrorModel, Spread, support_covariance
from shoecal_core.shoe.shoe import FEET


@dataclass(frozen=True)
class AnotherRun:
    """The training run that would win most if it were recorded once more.

    Attributes:
        run: its number.
        ratio: (3,) expected CoP error then over that of now: of both feet, left and right.
    """

    run: int
    ratio: FloatArray

    def to_json(self) -> dict[str, object]:
        """Figures for result files."""
        ratio = dict(zip(("both", *FEET), self.ratio.tolist(), strict=True))
        return {"run": self.run, "cop_ratio": ratio}


def another_run(
    joint: JointFit, model: ErrorModel, spreads: tuple[Spread, ...], tolerances: Tolerances
) -> AnotherRun:
    """The best of all training runs to record once more.

    It is the same motion in the same double support, with noise, zeros and placement drawn again.
    A motion that was not recorded may win more.

    Args:
        joint: the fit.
        model: its expected errors.
        spreads: of both feet, left and right over the sensing polygons.
        tolerances: of robot and shoes.
    """
    now = _lengths(spreads)
    found = []
    for run in joint.system.recorded:
        again = joint.with_another(run)
        more = replace(
            model,
            covariance=again.measuring[0],
            support_covariance=support_covariance(again, tolerances),
        )
        found.append(AnotherRun(run, _lengths(more.over_polygons()) / now))
    return min(found, key=lambda one: float(np.sum((one.ratio * now) ** 2)))


def _lengths(spreads: tuple[Spread, ...]) -> FloatArray:
    return np.array([one.cop_mae for one in spreads])
