"""Content of the report on a manual calibration."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.manual.calibrate import FootResult
from shoecal_core.manual.cells import CellFit
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe


@dataclass(frozen=True)
class ManualReport:
    """A manual calibration, or its first step.

    Attributes:
        robot, shoe: what was calibrated.
        calibration: with its verdict.
        cells: fits of the single cells; empty where only their calibration is known.
        feet: left and right under known weights; empty after the first step.
        provenance: lines that say where this is from.
    """

    robot: Robot
    shoe: Shoe
    calibration: Calibration
    cells: Sequence[CellFit] = ()
    feet: Sequence[FootResult] = ()
    provenance: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if not self.cells and not self.feet:
            raise ShoecalError("a manual calibration's report needs cells or loaded shoes")
        if self.calibration.channels != self.shoe.names:
            raise ShoecalError(
                f"calibration '{self.calibration.id}' has other channels than shoe "
                f"'{self.shoe.name}'; give the shoe that it is of"
            )
