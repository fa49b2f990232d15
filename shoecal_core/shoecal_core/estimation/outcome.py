"""A calibration and how it was found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.accuracy import ModelLimit
from shoecal_core.estimation.fit import SelfCalibration
from shoecal_core.estimation.joint_fit import JointFit
from shoecal_core.estimation.series import Errors
from shoecal_core.estimation.session_data import SessionData
from shoecal_core.estimation.uncertainty.assessment import Assessment
from shoecal_core.samples.zeros import ZeroFigures, zeros_json
from shoecal_core.screening.result import Screening


@dataclass(frozen=True)
class CalibrationOutcome:
    """A calibration with everything that speaks for or against it.

    Attributes:
        calibration: to apply, verdict included.
        stages: how it was found.
        data: what it was found from.
        assessment: its uncertainty, and what its data identify.
        train, test: numbers of the runs; those that were left out are in neither.
        modelled: errors against the model, by stage (`initial_guess`, `self_calibration`) and
            set (`train`, `test`); a set without runs is left out.
        joint: the fit of gains and offsets with all that may be wrong, which is put right in
            `data`; None for a walk.
        limits: by set, what a walk's model leaves of the errors whatever the calibration.
    """

    calibration: Calibration
    stages: SelfCalibration
    data: SessionData
    assessment: Assessment
    train: tuple[int, ...]
    test: tuple[int, ...]
    modelled: dict[str, dict[str, Errors]]
    joint: JointFit | None = None
    limits: Mapping[str, ModelLimit] = field(default_factory=dict)

    @property
    def screening(self) -> Screening:
        """What was found in the recording before the fit, and left out."""
        return self.data.screening

    @property
    def zeros(self) -> list[ZeroFigures]:
        """What each foot reads in the air, run by run."""
        return zeros_json(self.data.shoe, self.data.zeros, self.calibration.parameters)
