"""What the report on a calibration shows of its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.estimation.assessment import Assessment
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.screening.result import Screening
from shoecal_core.screening.settings import CalibrationSettings

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class AssessmentContent:
    """What the data identify, and what they do not.

    Attributes:
        assessment: of the calibration.
        fixed_below: relative uncertainty from which on a direction does not count as fixed.
        screening: what was left out before the fit.
    """

    assessment: Assessment
    fixed_below: float
    screening: Screening

    @property
    def carried(self) -> bool:
        """The model's own errors are part of the uncertainties; of walking they are not."""
        return self.assessment.budget is not None

    @property
    def error_name(self) -> str:
        """What the expected error of the CoP may be called."""
        return "expected CoP error" if self.carried else "known part of the CoP error"

    @property
    def possible(self) -> int:
        """Directions that the data could have fixed."""
        return max(self.assessment.told.possible, self.assessment.told.rank)


def assessment_content(
    outcome: CalibrationOutcome, settings: CalibrationSettings | None = None
) -> AssessmentContent:
    """What the data of a calibration identify.

    Args:
        outcome: of `calibrate_session`.
        settings: that it was called with.
    """
    return AssessmentContent(
        assessment=outcome.assessment,
        fixed_below=(settings or CalibrationSettings()).fixed_below,
        screening=outcome.screening,
    )
