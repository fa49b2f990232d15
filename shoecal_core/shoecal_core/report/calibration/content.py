"""Content of the report on a calibration."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.comparison import StanceComparison, stage_errors
from shoecal_core.estimation.fit import SelfCalibration
from shoecal_core.estimation.series import Errors, Series, errors
from shoecal_core.estimation.uncertainty.assessment import NORMAL_95, Assessment
from shoecal_core.report.figures.series import joined
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.zeros import ZeroFigures
from shoecal_core.screening.result import Screening
from shoecal_core.shoe.shoe import Shoe


@dataclass(frozen=True)
class RunReport:
    """One run.

    Attributes:
        stances: one in double support, many in walking; all of one run and one set.
        snapshot_time: (k,) instants to show the robot at [s].
        snapshot_angles: (k, m) its joint angles then [rad].
    """

    stances: tuple[StanceComparison, ...]
    snapshot_time: FloatArray
    snapshot_angles: FloatArray

    def __post_init__(self) -> None:
        if len({(one.stance.run, one.set) for one in self.stances}) != 1:
            raise ShoecalError("a run's report needs the stances of one run and of one set")
        if self.snapshot_angles.shape[:1] != self.snapshot_time.shape:
            raise ShapeError(
                "snapshot_angles", f"({len(self.snapshot_time)}, m)", self.snapshot_angles.shape
            )

    @property
    def run(self) -> int:
        """Its number."""
        return self.stances[0].stance.run

    @property
    def test(self) -> bool:
        """It was kept from the fit."""
        return self.stances[0].set == "test"

    @property
    def double_support(self) -> bool:
        """Both feet stood where they were all the time."""
        return len(self.stances) == 1 and all(self.stances[0].stance.loaded)

    def series(self, name: str) -> Series:
        """All stances in a row: `guess`, `measured`, `modelled`, `truth` or `reference`."""
        return joined([getattr(one, name) for one in self.stances])

    def errors(self, name: str) -> Errors:
        """Errors of `guess`, `measured` or `modelled` against the reference."""
        return errors([(getattr(one, name), one.reference) for one in self.stances])


@dataclass(frozen=True)
class CalibrationReport:
    """Everything that a calibration's report shows.

    Attributes:
        robot, shoe: what was calibrated.
        calibration: with its verdict.
        stages: how it was found; None where it was not found from these runs.
        assessed: what the data identify and what not; None likewise.
        screening: what was left out before the fit.
        runs: training runs first.
        timing: seconds by stage, for example `plan`, `record`, `solve`, `total`.
        provenance: lines that say where this is from; what is simulated and what is real.
        zeros: what feet read in the air.
    """

    robot: Robot
    shoe: Shoe
    calibration: Calibration
    stages: SelfCalibration | None
    runs: tuple[RunReport, ...]
    assessed: Assessment | None = None
    screening: Screening = field(default_factory=Screening)
    timing: Mapping[str, float] = field(default_factory=dict)
    provenance: tuple[str, ...] = ()
    zeros: tuple[ZeroFigures, ...] = ()

    def __post_init__(self) -> None:
        if not self.runs:
            raise ShoecalError("a calibration's report needs at least one run; give it runs")
        if len({one.truth is None for run in self.runs for one in run.stances}) > 1:
            raise ShoecalError("some runs have a truth and some have none; give all or none")
        if self.calibration.channels != self.shoe.names:
            raise ShoecalError(
                f"calibration '{self.calibration.id}' has other channels than shoe "
                f"'{self.shoe.name}'; give the shoe that it is of"
            )

    @cached_property
    def errors(self) -> dict[str, dict[str, Errors]]:
        """Errors against the reference by stage and set."""
        return stage_errors([one for run in self.runs for one in run.stances])

    @property
    def half_widths(self) -> FloatArray:
        """(2n,) half widths of the 95 % intervals of gains and offsets, in their units.

        NaN where unknown. Where known, patterns that no data show are left out of them.
        """
        covariance = self.calibration.covariance
        width: FloatArray = np.full(2 * len(self.shoe.names), np.nan)
        if self.assessed is not None:
            width = self.assessed.interval()[: len(width)]
        elif covariance is not None:
            width = NORMAL_95 * np.sqrt(np.diag(covariance))
        return width

    @property
    def has_truth(self) -> bool:
        """The runs are compared with a truth, not only with the model."""
        return self.runs[0].stances[0].truth is not None

    @property
    def reference(self) -> str:
        """Name of what errors are counted against."""
        return "truth" if self.has_truth else "model"

    @property
    def judged(self) -> str:
        """The set whose errors speak for the calibration: `test` where there is one."""
        return "test" if any(run.test for run in self.runs) else "train"
