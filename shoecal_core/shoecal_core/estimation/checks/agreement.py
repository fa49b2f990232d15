"""Does the robot's weight bear a calibration out? Judged live, by about a second of readings.

On the floor the calibrated forces add up to the weight, in the air to nothing, whatever the robot
does slowly. While it stands still its CoP is the modelled one, too. What is stated of a
calibration's uncertainty counts only between two bounds, which no statement moves.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.drift import (
    FALSE_ALARM,
    expected_variance,
    largest,
    longest,
    shares_model,
)
from shoecal_core.estimation.checks.standstill import ModelTolerance, compare, hanging_feet
from shoecal_core.estimation.checks.usable import MOST_WIDTHS
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.sensing import Sensing
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import by_parameters

DOUBT_SHARE = 0.02
"""Of the weight: creep, hysteresis and slow motion take GRF off it by less, however well a
calibration says it knows it."""
CONTRADICTION_SHARE = 0.05
"""Of the weight: beyond it, or so far from zero in the air, no statement makes forces usable."""
REST_SHARE = 0.02
"""Of the weight, standard deviation of the parts' GRF: with more something moves or touches the
robot."""
PARTS = 5
"""Of a window: of a second 0.2 s each, shorter than it takes to lift a robot."""


class Judgement(IntEnum):
    """What weight or model say of a calibration; the larger one of two counts."""

    AGREES = 0
    DISAGREES = 1
    CONTRADICTS = 2


@dataclass(frozen=True)
class Compared:
    """One error, and what may be expected of it.

    Attributes:
        error: measured less expected, or the size of that [N or m].
        limit: size that is stated as expected.
        bound: size beyond which the measured value is not usable, at least the limit.
    """

    error: float
    limit: float
    bound: float

    @property
    def judgement(self) -> Judgement:
        """By its size."""
        if abs(self.error) <= self.limit:
            return Judgement.AGREES
        return Judgement.DISAGREES if abs(self.error) <= self.bound else Judgement.CONTRADICTS


@dataclass(frozen=True)
class Agreement:
    """A calibration against the robot.

    Attributes:
        grf: GRF less the weight [N].
        cop: distance of the CoP from the modelled one [m]; None where it was not judged.
    """

    grf: Compared
    cop: Compared | None = None

    @property
    def judgement(self) -> Judgement:
        """The worse one of both."""
        return max(one.judgement for one in (self.grf, self.cop) if one is not None)

    @property
    def reason(self) -> str:
        """Errors and their limits, in words."""
        grf, cop = self.grf, self.cop
        text = (
            f"GRF is {grf.error:+.2f} N off the weight (expected within {grf.limit:.2f} N, usable "
            f"within {grf.bound:.2f} N)"
        )
        if cop is not None:
            text += (
                f", CoP {1e3 * cop.error:.1f} mm off the model (within {1e3 * cop.limit:.1f} mm, "
                f"usable within {1e3 * cop.bound:.1f} mm)"
            )
        return text


def judge(
    calibration: Calibration,
    robot: Robot,
    shoe: Shoe,
    readings: FloatArray,
    body: BodyStates | None,
    tolerance: ModelTolerance,
    *,
    false_alarm: float = FALSE_ALARM,
) -> Agreement | None:
    """Hold a calibration against weight and model.

    Args:
        calibration: of these shoes.
        robot: whose weight is known.
        shoe: with its channels.
        readings: (k, n) raw, of about the last second, in order.
        body: one sample of a robot that has stood still for the second half of them; None: the CoP
            is not judged.
        tolerance: of weight and modelled CoP.
        false_alarm: chance that an error without a cause is beyond its limit.

    Returns:
        None where nothing can be judged: in the air, or while something moves or touches the robot.

    Raises:
        WrongShoeError: for another shoe's calibration.
    """
    weight, sensing = robot.weight, calibration.sensing(shoe)
    total = sensing.measure(readings).total_grf
    levels = _levels(total)
    known = largest(tolerance.force**2, false_alarm)
    bound = max(CONTRADICTION_SHARE * weight, known)
    if not _at_rest(levels, bound, weight) or np.abs(levels).max() <= bound:
        return None
    limit = np.clip(
        largest(_grf_variance(calibration, sensing, readings, tolerance), false_alarm),
        max(DOUBT_SHARE * weight, known),
        bound,
    )
    grf = Compared(float(total.mean()) - weight, float(limit), bound)
    if body is None or grf.judgement is Judgement.CONTRADICTS:
        return Agreement(grf)
    mean = readings[len(readings) // 2 :].mean(axis=0)
    found = compare(
        calibration, shoe, mean, body, hanging_feet(calibration, shoe, mean, body), tolerance
    )
    if not np.isfinite(found.cop):
        return Agreement(grf)  # channels that give a force alone
    own = np.diag(found.variance(mean, calibration.joint_covariance))[:3]
    variance = expected_variance(own, found.tolerance[:3], shared=shares_model(calibration))
    known = longest(found.tolerance[1:3] ** 2, false_alarm)
    bound = max(MOST_WIDTHS * min(foot.half_width for foot in robot.feet), known)
    limit = np.clip(longest(variance[1:], false_alarm), known, bound)
    return Agreement(grf, Compared(found.cop, float(limit), bound))


def _grf_variance(
    calibration: Calibration, sensing: Sensing, readings: FloatArray, tolerance: ModelTolerance
) -> float:
    """Of GRF less the weight, as the calibration and the weight state it [N^2]."""
    own = np.zeros((1, 1))
    if calibration.covariance is not None:
        jacobian = by_parameters(sensing.shoe.columns[None, :, 0], readings.mean(axis=0))
        own = jacobian @ calibration.covariance @ jacobian.T
    force = np.array([tolerance.force])
    return float(expected_variance(own[0], force, shared=shares_model(calibration))[0])


def _levels(total: FloatArray) -> FloatArray:
    """Means of parts of GRF (k,) [N] in turn: noise of cheap cells is neither motion nor load."""
    parts = np.array_split(total, min(PARTS, len(total)))
    return np.array([part.mean() for part in parts])


def _at_rest(levels: FloatArray, bound: float, weight: float) -> bool:
    """Whether GRF is one force: what is lifted, set down or pushed shows others in turn.

    Forces that are beyond all doubt throughout need not be alike: gains may be far too large.
    """
    beyond = levels.min() > weight + bound or levels.max() < -bound
    return bool(beyond or levels.std() <= REST_SHARE * weight)
