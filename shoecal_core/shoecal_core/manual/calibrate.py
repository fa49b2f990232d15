"""From readings under known weights to a calibration that has been checked (paper, section III)."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.correction_fit import MINIMUM_GAIN
from shoecal_core.estimation.series import Mae, cop_mae, grf_mae
from shoecal_core.manual.assembly import assembled
from shoecal_core.manual.cells import CellFit, fit_cells, law
from shoecal_core.manual.checks import (
    check_cells,
    check_foot,
    check_lines,
    check_plan,
)
from shoecal_core.manual.correction import CorrectionFit, fit_correction
from shoecal_core.manual.measurements import Measurements
from shoecal_core.manual.shoe_loads import ShoeLoads, loaded
from shoecal_core.robot.robot import Robot
from shoecal_core.screening.verdict import Finding, judge
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

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
class CopResult:
    """The CoP of one shoe under its weights.

    Attributes:
        corrected: (N, 2) with the correction; as measured where none is kept [m].
        predicted: (N, 2) of each load by a correction fitted to the others [m].
        before, after: error without and with the correction (eq. 8) [m].
        held_out: the same of `predicted` [m].
    """

    corrected: FloatArray
    predicted: FloatArray
    before: Mae
    after: Mae
    held_out: Mae


@dataclass(frozen=True)
class FootResult:
    """One shoe under its weights.

    Attributes:
        loads: what stood where, what was expected and what was measured, uncorrected.
        shift: (k,) what assembling added to the offsets of the foot's cells [N].
        grf: error of the force (eq. 7) [N].
        cop: None where the channels give a force alone.
    """

    loads: ShoeLoads
    shift: FloatArray
    grf: Mae
    cop: CopResult | None

    @property
    def known_cop(self) -> CopResult:
        """The CoP of a shoe that has one.

        Raises:
            ShoecalError: for channels that give a force alone.
        """
        if self.cop is None:
            raise ShoecalError("the channels of this shoe give a force alone, so no CoP")
        return self.cop


@dataclass(frozen=True)
class ManualCalibration:
    """A manual calibration with everything that speaks for or against it.

    Attributes:
        calibration: to apply, verdict included.
        cells: fits of the single cells; empty where only their calibration is known.
        feet: left, right; or that of a single shoe.
    """

    calibration: Calibration
    cells: tuple[CellFit, ...]
    feet: tuple[FootResult, ...]


def calibrate_manually(
    shoe: Shoe, robot: Robot, cells: Measurements, loads: Measurements
) -> ManualCalibration:
    """Both steps of a manual calibration.

    Args:
        shoe: that was calibrated.
        robot: that wears it (`load_robot(path, shoe)`): nodes take calibrations of their robot
            only, and its weight goes with them.
        cells: readings of the single cells.
        loads: readings of the shoe under weights.

    Raises:
        ShoecalError: when no calibration can be had from the readings at all. One that was found
            but must not be used comes back with the verdict FAIL.
    """
    first = calibrate_cells(shoe, robot, cells)
    return calibrate_shoe(shoe, robot, first.calibration, loads, fits=first.cells)


def calibrate_cells(shoe: Shoe, robot: Robot, cells: Measurements) -> CellsCalibration:
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
        cells.end_ns,
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
) -> ManualCalibration:
    """The second step: offsets of the assembled shoe, and its CoP correction (eqs. 4 to 6).

    A correction is kept only where it predicts loads it was not fitted to better.

    Args:
        shoe, robot: see `calibrate_manually`.
        cells: of the first step.
        loads: readings of the shoe under weights.
        fits: of the first step, where they are at hand.
        planned: loads of one foot that a whole calibration has; None: those read.

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
    for foot in shoe.feet:
        found = loaded(loads, foot, parameters)
        grf, moved = grf_mae(found.force, found.expected_force), shift[shoe.of_foot(foot)]
        place = None
        if shoe.gives_cop[foot]:
            place, kept = _cop(found, fit_correction(loads, found))
            corrections += kept
        feet.append(FootResult(found, moved, grf, place))
        before, after = (None, None) if place is None else (place.before, place.after)
        findings += check_foot(foot, grf, before, after, moved)
        if planned is not None:
            findings += check_plan(foot, len(found.loads), planned)
    calibration = _calibration(
        shoe, robot, parameters, covariance, tuple(corrections), findings, loads.end_ns
    )
    return ManualCalibration(calibration, fits, tuple(feet))


def of_shoe(cells: Calibration, shoe: Shoe) -> Calibration:
    """A calibration of single cells, of the channels of a shoe only.

    Args:
        cells: of both shoes.
        shoe: of one foot, of the same file.

    Raises:
        WrongShoeError: for cells of another shoe.
    """
    if set(shoe.names) < set(cells.channels):
        places = np.array([cells.channels.index(name) for name in shoe.names])
        both = np.concatenate([places, len(cells.channels) + places])
        covariance = cells.covariance
        cells = replace(
            cells,
            channels=shoe.names,
            parameters=ChannelParameters(
                cells.parameters.gain[places], cells.parameters.offset[places]
            ),
            covariance=None if covariance is None else covariance[np.ix_(both, both)],
        )
    cells.sensing(shoe)
    return cells


def _cop(found: ShoeLoads, fit: CorrectionFit) -> tuple[CopResult, list[CopCorrection]]:
    """What a correction wins, and the correction where it is kept."""
    before = cop_mae(found.cop, found.expected_cop)
    others = cop_mae(fit.held_out, found.expected_cop)
    if others.mean < (1.0 - MINIMUM_GAIN) * before.mean:
        after = cop_mae(fit.corrected, found.expected_cop)
        return CopResult(fit.corrected, fit.held_out, before, after, others), [fit.correction]
    return CopResult(found.cop, found.cop, before, before, before), []


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
    for line in cells.reasons:
        verdict, _, reason = line.partition(": ")
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
