"""The report on a manual calibration, as a page and as a file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.uncertainty.assessment import NORMAL_95
from shoecal_core.manual.calibrate import FootResult
from shoecal_core.manual.cells import CellFit
from shoecal_core.report.calibration.report import made, verdict_of
from shoecal_core.report.calibration.tables import belongs_to
from shoecal_core.report.figures.feet import foot_shape
from shoecal_core.report.figures.loads import KnownLoads, cop_under_loads, forces_under_loads
from shoecal_core.report.figures.tracks import ChannelTrack, tracks
from shoecal_core.report.html import write_page
from shoecal_core.report.next_step import after_cells
from shoecal_core.report.page import Group, KeyFigure, Page, Picture, Section, Table
from shoecal_core.report.quantities import (
    UNKNOWN,
    channel_units,
    mean_error,
    quantity,
    size,
    uncertain,
)
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import FEET, Shoe

LEAST_LOADS = 3
"""Two loads lie on every line."""


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


def shoe_pictures(content: ManualReport, foot: FootResult) -> tuple[Picture, ...]:
    """One shoe: force, then CoP without and with the correction."""
    loads = known_loads(content, foot)
    pictures = [
        Picture(
            "GRF under known weights",
            forces_under_loads(loads),
            f"GRF {mean_error(foot.grf, 'mN', 1e3)} (MAE ± standard deviation).",
        )
    ]
    if foot.cop is None:
        return tuple(pictures)
    pictures.append(
        Picture(
            "CoP as measured",
            cop_under_loads(loads, corrected=False),
            f"Before the correction: {mean_error(foot.cop.before, 'mm', 1e3)}.",
            tall=True,
        )
    )
    if any(one.foot == foot.loads.foot for one in content.calibration.corrections):
        pictures.append(
            Picture(
                "CoP corrected",
                cop_under_loads(loads, corrected=True),
                f"After it: {mean_error(foot.cop.after, 'mm', 1e3)}; each load predicted from the "
                f"others: {mean_error(foot.cop.held_out, 'mm', 1e3)}.",
                tall=True,
            )
        )
    return tuple(pictures)


def known_loads(content: ManualReport, foot: FootResult) -> KnownLoads:
    """CoPs around their holes: the shoe's own weight, which moves each a little, taken off."""
    found = foot.loads
    holes = content.shoe.holes[found.foot]
    assert holes is not None
    places = np.array([holes.position(load.place) for load in found.loads])
    corrected = found.cop if foot.cop is None else foot.cop.corrected
    return KnownLoads(
        foot=foot_shape(content.robot, content.shoe, found.foot),
        masses=found.masses,
        force=found.force,
        expected_force=found.expected_force,
        places=places,
        measured=places + found.cop - found.expected_cop,
        corrected=places + corrected - found.expected_cop,
    )


def cell_pictures(content: ManualReport) -> tuple[Picture, ...]:
    """How far single cells are off their lines."""
    shoe, pictures = content.shoe, []
    lines = [
        ChannelTrack(fit.name, fit.masses, 1e3 * fit.residuals)
        for fit in content.cells
        if len(fit.masses) >= LEAST_LOADS
    ]
    for foot, side in enumerate(FEET):
        own = [line for line in lines if shoe.foot[shoe.index(line.label)] == foot]
        if own:
            pictures.append(
                Picture(
                    f"Single cells of the {side} shoe",
                    tracks(own, "mass on the cell (kg)", "Δ force (mN)"),
                    "Force by each cell's own line, less the weight that stood on it.",
                )
            )
    return tuple(pictures)


def loads_table(content: ManualReport) -> Table:
    """Errors of each shoe under its weights."""
    rows = tuple(
        (
            f"{FEET[foot.loads.foot]} shoe",
            str(len(foot.loads.loads)),
            mean_error(foot.grf, "mN", 1e3),
            *(
                ("no CoP",) * 3
                if foot.cop is None
                else (
                    mean_error(mae, "mm", 1e3)
                    for mae in (foot.cop.before, foot.cop.after, foot.cop.held_out)
                )
            ),
        )
        for foot in content.feet
    )
    return Table(
        "Errors under known weights",
        ("", "loads", "GRF", "CoP before", "CoP after", "CoP held out"),
        rows,
        "MAE ± standard deviation. Held out: each load predicted by a correction that knows all "
        "others; expect that of loads that were not read.",
    )


def cells_table(content: ManualReport) -> Table:
    """Gain and offset of every cell."""
    shoe, calibration = content.shoe, content.calibration
    unit, gain_unit = channel_units(shoe, torque=False)
    count = len(shoe.names)
    half = np.full(2 * count, np.nan)
    if calibration.covariance is not None:
        half = NORMAL_95 * np.sqrt(np.diag(calibration.covariance))
    scatter = {fit.name: fit.residual_std for fit in content.cells}
    shift = np.full(count, math.nan)
    for foot in content.feet:
        shift[shoe.of_foot(foot.loads.foot)] = foot.shift
    rows = []
    for index, name in enumerate(shoe.names):
        row = [
            name,
            uncertain(calibration.parameters.gain[index], half[index], gain_unit),
            uncertain(calibration.parameters.offset[index], half[count + index], unit),
        ]
        if content.feet:
            row.append(quantity(float(shift[index]), unit, 3))
        if content.cells:
            row.append(size(1e3 * scatter.get(name, math.nan), "mN"))
        rows.append(tuple(row))
    header = ["cell", "gain", "offset"]
    header += ["shifted by assembling"] if content.feet else []
    header += ["about its own line"] if content.cells else []
    note = "Force = gain · reading + offset"
    note += "; ± is half of the 95 % interval." if np.isfinite(half).all() else "."
    return Table("Cells", tuple(header), tuple(rows), note)


def corrections_table(content: ManualReport) -> Table | None:
    """Where each correction holds; None before the shoes were loaded."""
    if not content.feet:
        return None
    found = {one.foot: one for one in content.calibration.corrections}
    rows = []
    for foot in content.feet:
        side, one = FEET[foot.loads.foot], found.get(foot.loads.foot)
        if one is None:
            force_alone = "none: its channels give a force alone"
            useless = "none: it did not help on loads held out"
            why = force_alone if foot.cop is None else useless
            rows.append((f"{side} shoe", why, UNKNOWN))
            continue
        (x_low, y_low), (x_high, y_high) = 1e3 * one.cop_range
        rows.append(
            (
                f"{side} shoe",
                f"{quantity(x_low, 'mm', 0)} to {quantity(x_high, 'mm', 0)}",
                f"{quantity(y_low, 'mm', 0)} to {quantity(y_high, 'mm', 0)}",
            )
        )
    return Table(
        "CoP correction",
        ("", "known for x", "known for y"),
        tuple(rows),
        "Beyond these places the correction extrapolates, and says so in use.",
    )


def manual_report(path: Path, content: ManualReport) -> None:
    """Write the report as one self-contained HTML file.

    Raises:
        FileError: when it cannot be written.
    """
    write_page(path, manual_page(content))


def manual_page(content: ManualReport) -> Page:
    """The report, ready to be rendered; the same content makes the same page."""
    following = None if content.feet else after_cells(content.calibration.verdict)
    what = "Manual calibration" if content.feet else "Single cells"
    step = "single cells and loaded shoes" if content.feet else "first step of two: single cells"
    return Page(
        title=f"{what} of {content.shoe.name}",
        subtitle=" · ".join([step, *made(content.calibration), f"worn by {content.robot.name}"]),
        verdict=verdict_of(content.calibration, following),
        key_figures=_key_figures(content),
        sections=(*_loads(content), _cells(content), _details(content)),
        provenance=content.provenance,
    )


def _key_figures(content: ManualReport) -> tuple[KeyFigure, ...]:
    keys = []
    for foot in content.feet:
        side = FEET[foot.loads.foot]
        if foot.cop is not None:
            keys.append(
                KeyFigure(f"CoP error, {side} shoe", mean_error(foot.cop.held_out, "mm", 1e3),
                          "each load predicted from the others; uncorrected: "
                          + mean_error(foot.cop.before, "mm", 1e3))
            )  # fmt: skip
        keys.append(
            KeyFigure(f"GRF error, {side} shoe", mean_error(foot.grf, "mN", 1e3),
                      f"{len(foot.loads.loads)} loads")
        )  # fmt: skip
    scatter = [fit.residual_std for fit in content.cells if np.isfinite(fit.residual_std)]
    if scatter:
        keys.append(
            KeyFigure("single cells about their lines", size(1e3 * max(scatter), "mN"),
                      "the worst cell, standard deviation")
        )  # fmt: skip
    keys.append(KeyFigure("cells", str(len(content.shoe.names)), f"of {content.shoe.name}"))
    return tuple(keys)


def _loads(content: ManualReport) -> tuple[Section, ...]:
    if not content.feet:
        return ()
    groups = [Group(tables=(loads_table(content),))]
    groups += [
        Group(
            title=f"{FEET[foot.loads.foot].capitalize()} shoe",
            pictures=shoe_pictures(content, foot),
        )
        for foot in content.feet
    ]
    return (
        Section(
            "Under known weights",
            tuple(groups),
            "Weights that are known, at places that are known: nothing here rests on a model of "
            "the robot.",
        ),
    )


def _cells(content: ManualReport) -> Section:
    group = Group(pictures=cell_pictures(content), tables=(cells_table(content),))
    return Section("Cells", (group,))


def _details(content: ManualReport) -> Section:
    correction = corrections_table(content)
    tables = [] if correction is None else [correction]
    tables.append(belongs_to(content.calibration, content.robot))
    return Section("Details", (Group(tables=tuple(tables)),))
