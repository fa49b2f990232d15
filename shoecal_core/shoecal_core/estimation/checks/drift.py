"""Is a calibration still right? Checked in one standstill.

Calibrated GRF and CoP may differ from weight and modelled CoP by what the calibration is uncertain
of, and by what weight and model may be off. What is beyond both has drifted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from scipy.special import chdtri

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.standstill import (
    ModelTolerance,
    StandstillResiduals,
    compare,
    hanging_feet,
)
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.shoe.shoe import FEET, Shoe

FALSE_ALARM = 0.003
"""Chance that GRF or CoP looks drifted while it is not, where the stated deviations hold."""
SOURCES_OF_MODEL = ("self",)
"""Calibrations that took weight and model for the truth."""
LEFT_SHARE = 0.5
"""Most of the model's error that a fit to it leaves in the difference at one standstill."""


class UnloadedError(ShoecalError):
    """No foot stands on the floor: nothing can be compared."""


@dataclass(frozen=True)
class Drift:
    """How far calibrated forces are off, and how far they may be.

    Attributes:
        grf_error: GRF less the weight [N].
        cop_error: distance of the CoP from the modelled one [m].
        hanging_error: force on the foot that hangs [N]; NaN where none does.
        grf_limit, cop_limit, hanging_limit: sizes that are expected of them without drift.
        hanging: name of the foot that hangs, else empty.
        covered: the calibration states its uncertainty; else the limits are the model's alone.
    """

    grf_error: float
    cop_error: float
    hanging_error: float
    grf_limit: float
    cop_limit: float
    hanging_limit: float
    hanging: str
    covered: bool

    @property
    def grf_beyond(self) -> bool:
        """Whether GRF is off by more than is expected."""
        return abs(self.grf_error) > self.grf_limit

    @property
    def cop_beyond(self) -> bool:
        """Whether the CoP is."""
        return self.cop_error > self.cop_limit

    @property
    def beyond(self) -> bool:
        """Whether anything is."""
        # A foot that does not hang has neither error nor limit: NaN is not above NaN.
        return self.grf_beyond or self.cop_beyond or abs(self.hanging_error) > self.hanging_limit

    @property
    def reason(self) -> str:
        """Errors and what is expected, in words."""
        text = (
            f"GRF is {self.grf_error:+.2f} N off the weight (expected within "
            f"{self.grf_limit:.2f} N), CoP {1e3 * self.cop_error:.1f} mm off the model "
            f"(within {1e3 * self.cop_limit:.1f} mm)"
        )
        if self.hanging:
            text += (
                f", the {self.hanging} foot in the air reads {self.hanging_error:+.2f} N "
                f"(within {self.hanging_limit:.2f} N)"
            )
        if not self.covered:
            text += "; the calibration states no uncertainty, so these are weight's and model's"
        return text


def shares_model(calibration: Calibration) -> bool:
    """Whether a calibration took weight and model for the truth, as self-calibrations do.

    Their errors are then on both sides of every comparison.
    """
    return calibration.source in SOURCES_OF_MODEL or bool(calibration.fitted_runs)


def check_drift(
    calibration: Calibration,
    shoe: Shoe,
    readings: FloatArray,
    body: BodyStates,
    tolerance: ModelTolerance,
    *,
    false_alarm: float = FALSE_ALARM,
) -> Drift:
    """Compare one standstill with weight and model.

    Args:
        calibration: in force.
        shoe: its shoes.
        readings: (n,) mean raw readings of a standstill.
        body: one sample of the same standstill.
        tolerance: of weight and modelled CoP.
        false_alarm: chance that each of the errors is beyond its limit without drift.

    Raises:
        UnloadedError: when the robot does not stand.
        WrongShoeError, ShapeError: for another shoe's calibration or readings.
    """
    hanging = hanging_feet(calibration, shoe, readings, body)
    if all(hanging):
        raise UnloadedError("neither foot carries the robot: put it on the floor")
    found = compare(calibration, shoe, readings, body, hanging, tolerance)
    return drift_of(found, calibration, readings, false_alarm=false_alarm)


def drift_of(
    found: StandstillResiduals,
    calibration: Calibration,
    readings: FloatArray,
    *,
    false_alarm: float = FALSE_ALARM,
) -> Drift:
    """Drift by the comparison of a loaded robot, for raw readings (n,); see `check_drift`."""
    own = np.diag(found.variance(readings, calibration.joint_covariance))
    variance = expected_variance(own[:3], found.tolerance[:3], shared=shares_model(calibration))
    foot = found.hanging.index(True) if any(found.hanging) else None
    return Drift(
        grf_error=found.grf,
        cop_error=found.cop,
        hanging_error=float("nan") if foot is None else float(found.error[3]),
        grf_limit=largest(float(variance[0]), false_alarm),
        cop_limit=longest(variance[1:3], false_alarm),
        hanging_limit=(
            float("nan")
            if foot is None
            else largest(float(own[3] + found.tolerance[3] ** 2), false_alarm)
        ),
        hanging="" if foot is None else FEET[foot],
        covered=calibration.covariance is not None,
    )


def largest(variance: float, chance: float) -> float:
    """Size that a normal error of this variance exceeds with a chance."""
    return NormalDist().inv_cdf(1.0 - chance / 2.0) * math.sqrt(variance)


def longest(variance: FloatArray, chance: float) -> float:
    """Length that a normal error with variances (2,) along x and y exceeds with a chance.

    Its square is taken as a multiple of chi-squared with the same mean and variance
    (Satterthwaite): exact where both are alike, and where one is zero.
    """
    total = float(variance.sum())
    if total <= 0.0:
        return 0.0
    squares = float((variance**2).sum())
    return float(np.sqrt(squares / total * chdtri(total**2 / squares, chance)))


def expected_variance(own: FloatArray, tolerance: FloatArray, *, shared: bool) -> FloatArray:
    """(k,) variance of the differences in GRF, or in GRF and CoP, without drift.

    Args:
        own: variance by the calibration.
        tolerance: standard deviations of weight and modelled CoP.
        shared: the calibration took both for the truth: the weight's error, all of it in `own`,
            cancels, and so does most of the model's.
    """
    if not shared:
        return own + tolerance**2
    cancelled = np.zeros(len(tolerance))
    cancelled[0] = tolerance[0] ** 2
    return np.asarray(np.maximum(own - cancelled, (LEFT_SHARE * tolerance) ** 2))
