"""The report on a manual calibration as a page, and as a file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from shoecal_core.report.calibration_report import made, verdict_of
from shoecal_core.report.calibration_tables import belongs_to
from shoecal_core.report.html import write_page
from shoecal_core.report.manual_content import ManualReport
from shoecal_core.report.manual_figures import cell_pictures, shoe_pictures
from shoecal_core.report.manual_tables import cells_table, corrections_table, loads_table
from shoecal_core.report.page import Group, KeyFigure, Page, Section
from shoecal_core.report.quantities import mean_error, size
from shoecal_core.shoe.shoe import FEET


def manual_report(path: Path, content: ManualReport) -> None:
    """Write the report as one self-contained HTML file.

    Raises:
        FileError: when it cannot be written.
    """
    write_page(path, manual_page(content))


def manual_page(content: ManualReport) -> Page:
    """The report, ready to be rendered; the same content makes the same page."""
    what = "Manual calibration" if content.feet else "Single cells"
    step = "single cells and loaded shoes" if content.feet else "first step of two: single cells"
    return Page(
        title=f"{what} of {content.shoe.name}",
        subtitle=" · ".join([step, *made(content.calibration), f"worn by {content.robot.name}"]),
        verdict=verdict_of(content.calibration),
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
