"""How far calibrated GRF and CoP may be off the truth, load by load.

An uncertain parameter moves them, and so does a tolerance of the shoe itself; the two are not
independent, as the fit has swallowed part of the tolerance. With J the derivative of GRF and CoP to
the parameters, K how tolerances moved the parameters, and B what tolerances of the shoe add to what
is measured, the error is (J K + B) t + J n.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.tolerances import Effects, ModelTolerances
from shoecal_core.calibration.uncertainty import Uncertainty
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.landmarks import sensing_hull
from shoecal_core.planning.supports.polygon_error import places_over
from shoecal_core.sensing.expected_error import wrench_slopes
from shoecal_core.sensing.load_cases import double_support_outputs, single_support_outputs
from shoecal_core.sensing.sensing import MINIMUM_FORCE
from shoecal_core.sensing.wrench import (
    ChannelParameters,
    columns_in_left,
    combined,
    foot_wrenches,
)

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class Spread:
    """Standard deviations of a wrench's error at p load cases.

    Attributes:
        places: (p, 2) the CoP, in the frame that it is told in [m].
        grf: (p,) [N].
        cop: (p, 2) along x and y [m]; NaN where nothing is loaded.
    """

    places: FloatArray
    grf: FloatArray
    cop: FloatArray

    @property
    def cop_length(self) -> FloatArray:
        """(p,) root mean square length of the CoP's error [m]."""
        length: FloatArray = np.linalg.norm(self.cop, axis=1)
        return length


class ErrorModel:
    """Expected errors of one calibration."""

    def __init__(
        self,
        parameters: ChannelParameters,
        uncertainty: Uncertainty,
        tolerances: ModelTolerances,
    ) -> None:
        self.parameters, self.uncertainty, self.tolerances = parameters, uncertainty, tolerances
        self._shoe = tolerances.shoe

    def both_feet(self, outputs: FloatArray, support: DoubleSupport) -> Spread:
        """Of both feet together in the left sole's frame, for outputs (p, n) [N or N m]."""
        wrenches = combined(foot_wrenches(self._shoe, outputs), support)
        shifts = self._measured(outputs, support).cop
        return self._spread(columns_in_left(self._shoe, support), wrenches, outputs, shifts)

    def foot(self, outputs: FloatArray, foot: int) -> Spread:
        """Of one foot in its own sole's frame, for outputs (p, n) of all channels [N or N m]."""
        columns = np.where((self._shoe.foot == foot)[:, None], self._shoe.columns, 0.0)
        wrenches = foot_wrenches(self._shoe, outputs)[:, foot]
        anywhere = DoubleSupport(0.0, 0.0, 0.0)
        shifts = self._measured(outputs, anywhere).foot_cop[:, foot]
        return self._spread(columns, wrenches, outputs, shifts)

    def over_polygons(self) -> tuple[Spread, Spread, Spread]:
        """Both feet in the neutral double support, CoP anywhere in the hull of both sensing
        polygons; then left and right under half the weight, CoP anywhere in the foot's own.
        """
        robot = self.tolerances.robot
        support = DoubleSupport(*(float(value) for value in robot.support_range.neutral))
        places = places_over(np.array(sensing_hull(robot, support).exterior.coords))
        outputs = double_support_outputs(self._shoe, support, robot.weight, places)
        both = self.both_feet(outputs, support)
        left, right = (
            self.foot(
                single_support_outputs(
                    self._shoe, index, robot.weight / 2.0, places_over(foot.sensing_polygon)
                ),
                index,
            )
            for index, foot in enumerate(robot.feet)
        )
        return both, left, right

    def _measured(self, outputs: FloatArray, support: DoubleSupport) -> Effects:
        placing = self.uncertainty.placing
        if not placing.shape[1]:
            placing = np.zeros((3, len(self.tolerances.causes)))
        return self.tolerances.measured_effects(outputs, support, placing)

    def _spread(
        self, columns: FloatArray, wrenches: FloatArray, outputs: FloatArray, shifts: FloatArray
    ) -> Spread:
        count = len(self._shoe.names)
        loaded = wrenches[:, 0] > MINIMUM_FORCE
        wrenches = np.where(loaded[:, None], wrenches, [1.0, 0.0, 0.0])
        slopes = wrench_slopes(columns, wrenches)
        readings = (outputs - self.parameters.offset) / self.parameters.gain
        jacobian = np.concatenate([slopes * readings[:, None, :], slopes], axis=2)
        found = self.uncertainty
        rest = (found.noise + found.prior)[: 2 * count, : 2 * count]
        variances = ((jacobian @ rest) * jacobian).sum(axis=2)
        if found.causes:
            moved = jacobian @ found.slopes[: 2 * count]
            moved[:, 1:] += shifts
            variances += ((moved @ found.agreed) * moved).sum(axis=2)
        std = np.sqrt(np.clip(variances, 0.0, None))
        places = np.stack((-wrenches[:, 2], wrenches[:, 1]), axis=1) / wrenches[:, :1]
        return Spread(
            np.where(loaded[:, None], places, np.nan),
            std[:, 0],
            np.where(loaded[:, None], std[:, 1:], np.nan),
        )
