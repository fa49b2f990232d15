"""From readings under known weights to a calibration that has been checked (paper, section III)."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.calibration import Calibration
from shoecal_core.calibration.checks import Finding, judge
from shoecal_core.calibration.correction_fit import MINIMUM_GAIN
from shoecal_core.calibration.manual.assembly import assembled
from shoecal_core.calibration.manual.cells import CellFit, fit_cells, law
from shoecal_core.calibration.manual.checks import (
    check_cells,
    check_foot,
    check_lines,
    check_plan,
)
from shoecal_core.calibration.manual.correction import CorrectionFit, fit_correction
from shoecal_core.calibration.manual.measurements import Measurements
from shoecal_core.calibration.manual.shoe_loads import ShoeLoads, loaded
from shoecal_core.calibration.metrics import Mae, cop_mae, grf_mae
from shoecal_core.errors import ShoecalError
from shoecal_core.model.robot import Robot
from shoecal_core.sensing.correction import CopCorrection
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters

FloatArray = NDArray[np.float64]
SOURCE = "manual"
CELLS_ONLY = (
    "single cells only: load the shoe next, its CoP is not corrected yet and assembling may have "
    "shifted its offsets"
)


@dataclass(frozen=True)
class CellsCalibration:
    """The first step: every cell by itself.

    Attributes:
        calibration: gains and offsets of the cells off their shoe, no corrections. Its verdict is
            never PASS: the shoe has not been loaded yet.
        cells: in the shoe's order.
    """

    calibration: Calibration
    cells: tuple[CellFit, ...]


@dataclass(frozen=True)
class FootResult:
    """One shoe under its weights.

    Attributes:
        loads: what stood where, what was expected and what was measured, uncorrected.
        corrected: (N, 2) CoP with the correction; as measured where none is kept [m].
        held_out: (N, 2) CoP of each load by a correction fitted to the others [m].
        shift: (k,) what assembling added to the offsets of the foot's cells [N].
        grf: error of the force (eq. 7) [N].
        cop_before, cop_after: error of the CoP without and with the correction (eq. 8) [m].
        cop_held_out: the same of `held_out` [m].
    """

    loads: ShoeLoads
    corrected: FloatArray
    held_out: FloatArray
    shift: FloatArray
    grf: Mae
    cop_before: Mae
    cop_after: Mae
    cop_held_out: Mae


@dataclass(frozen=True)
class ManualCalibration:
    """A manual calibration with everything that speaks for or against it.

    Attributes:
        calibration: to apply, verdict included.
        cells: fits of the single cells; empty where only their calibration is known.
        feet: left, right.
    """

    calibration: Calibration
    cells: tuple[CellFit, ...]
    feet: tuple[FootResult, FootResult]


def calibrate_manually(
    shoe: Shoe, robot: Robot, cells: Measurements, loads: Measurements, *, made_ns: int = 0
) -> ManualCalibration:
    """Both steps of a manual calibration.

    Args:
        shoe: that was calibrated.
        robot: that wears it (`load_robot(path, shoe)`): nodes take calibrations of their robot
            only, and its weight goes with them.
        cells: readings of the single cells.
        loads: readings of the shoe under weights.
        made_ns: time stamp [ns since the epoch]; 0: that of the last reading.

    Raises:
        ShoecalError: when no calibration can be had from the readings at all. One that was found
            but must not be used comes back with the verdict FAIL.
    """
    first = calibrate_cells(shoe, robot, cells)
    return calibrate_shoe(
        shoe, robot, first.calibration, loads, fits=first.cells, made_ns=made_ns or
        max(cells.end_ns, loads.end_ns),
    )  # fmt: skip


def calibrate_cells(
    shoe: Shoe, robot: Robot, cells: Measurements, *, made_ns: int = 0
) -> CellsCalibration:
    """The first step: gains and offsets of cells off their shoe (eq. 3).

    Raises:
        ShoecalError: see `fit_cells`.
    """
    _same_shoe(shoe, cells)
    fits = fit_cells(cells)
    gain, offset, covariance = law(fits)
    findings = check_cells(shoe, gain) + check_lines(fits)
    findings.append(Finding("WARN", CELLS_ONLY))
    calibration = _calibration(
        shoe, robot, ChannelParameters(gain, offset), covariance, (), findings,
        made_ns or cells.end_ns,
    )  # fmt: skip
    return CellsCalibration(calibration, fits)


def calibrate_shoe(
    shoe: Shoe,
    robot: Robot,
    cells: Calibration,
    loads: Measurements,
    *,
    fits: tuple[CellFit, ...] = (),
    planned: int | None = None,
    made_ns: int = 0,
) -> ManualCalibration:
    """The second step: offsets of the assembled shoe, and its CoP correction (eqs. 4 to 6).

    A correction is kept only where it predicts loads it was not fitted to better.

    Args:
        shoe, robot: see `calibrate_manually`.
        cells: of the first step.
        loads: readings of the shoe under weights.
        fits: of the first step, where they are at hand.
        planned: loads of one foot that a whole calibration has; None: those read.
        made_ns: time stamp [ns since the epoch]; 0: that of the last reading.

    Raises:
        WrongShoeError: for cells of another shoe.
        ShoecalError: for loads that do not fix the correction, or are not what they are said
            to be.
    """
    _same_shoe(shoe, loads)
    cells.sensing(shoe)
    if cells.source != SOURCE:
        raise ShoecalError(
            f"calibration '{cells.id}' is no manual one of single cells (its source is "
            f"'{cells.source}'): give the file that `shoecal manual cells` wrote"
        )
    if cells.shoe_hash != shoe.digest:
        raise ShoecalError(
            f"the cells' calibration '{cells.id}' was made with another file of shoe "
            f"'{cells.shoe}' than {shoe.path}; solve the cells' readings again"
        )
    parameters, covariance, shift = assembled(loads, cells.parameters, cells.covariance)
    feet = []
    corrections = []
    findings = _carried(cells, check_cells(shoe, parameters.gain))
    for foot in (0, 1):
        found = loaded(loads, foot, parameters)
        result, kept = _foot(found, fit_correction(loads, found), shift[shoe.of_foot(foot)])
        feet.append(result)
        corrections += kept
        findings += check_foot(foot, result.grf, result.cop_after, result.shift)
        if planned is not None:
            findings += check_plan(foot, len(found.loads), planned)
    calibration = _calibration(
        shoe, robot, parameters, covariance, tuple(corrections), findings, made_ns or loads.end_ns
    )
    return ManualCalibration(calibration, fits, (feet[0], feet[1]))


def _foot(
    found: ShoeLoads, fit: CorrectionFit, shift: FloatArray
) -> tuple[FootResult, list[CopCorrection]]:
    before = cop_mae(found.cop, found.expected_cop)
    others = cop_mae(fit.held_out, found.expected_cop)
    helps = others.mean < (1.0 - MINIMUM_GAIN) * before.mean
    corrected = fit.corrected if helps else found.cop
    result = FootResult(
        loads=found,
        corrected=corrected,
        held_out=fit.held_out if helps else found.cop,
        shift=shift,
        grf=grf_mae(found.force, found.expected_force),
        cop_before=before,
        cop_after=cop_mae(corrected, found.expected_cop),
        cop_held_out=others if helps else before,
    )
    return result, [fit.correction] if helps else []


def _same_shoe(shoe: Shoe, measurements: Measurements) -> None:
    if measurements.shoe.digest != shoe.digest:
        raise measurements.error(
            f"readings of shoe '{measurements.shoe.name}' ({measurements.shoe.path}), wanted are "
            f"those of '{shoe.name}' ({shoe.path})"
        )


def _carried(cells: Calibration, findings: Sequence[Finding]) -> list[Finding]:
    """Findings, and those of the first step that the second one does not make good."""
    known = {finding.reason for finding in findings} | {CELLS_ONLY}
    carried = []
    for told in cells.reasons:
        verdict, _, reason = told.partition(": ")
        if verdict in ("WARN", "FAIL") and reason not in known:
            carried.append(Finding(verdict, reason))
    return [*findings, *carried]


def _calibration(
    shoe: Shoe,
    robot: Robot,
    parameters: ChannelParameters,
    covariance: FloatArray | None,
    corrections: tuple[CopCorrection, ...],
    findings: Sequence[Finding],
    made_ns: int,
) -> Calibration:
    verdict = judge(findings)
    parts = [parameters.gain, parameters.offset]
    parts += [row for correction in corrections for row in (correction.x, correction.y)]
    digest = hashlib.sha256(b"".join(part.tobytes() for part in parts) + str(made_ns).encode())
    return Calibration(
        id=f"manual-{digest.hexdigest()[:12]}",
        source=SOURCE,
        made_ns=made_ns,
        robot=robot.name,
        shoe=shoe.name,
        robot_hash=robot.digest,
        shoe_hash=shoe.digest,
        channels=shoe.names,
        parameters=parameters,
        covariance=covariance,
        corrections=corrections,
        weight=robot.weight,
        time_offset=0.0,
        temperature=float("nan"),
        verdict=verdict.verdict,
        reasons=verdict.reasons,
    )
