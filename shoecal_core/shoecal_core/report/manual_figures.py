"""The figures of a manual calibration's report."""

from __future__ import annotations

import numpy as np

from shoecal_core.estimation.assessment import NORMAL_95
from shoecal_core.manual.calibrate import FootResult
from shoecal_core.report.figures.cells import CellLine, cell_residuals
from shoecal_core.report.figures.intervals import IntervalColumn, intervals
from shoecal_core.report.figures.loads import KnownLoads, cop_under_loads, forces_under_loads
from shoecal_core.report.foot_shapes import foot_shape
from shoecal_core.report.manual_content import ManualReport
from shoecal_core.report.page import Picture
from shoecal_core.report.quantities import channel_units, mean_error
from shoecal_core.shoe.shoe import FEET

LEAST_LOADS = 3
"""Two loads lie on every line."""


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
    """Gains and offsets, and how far single cells are off their lines."""
    shoe, calibration = content.shoe, content.calibration
    count = len(shoe.names)
    unit, gain_unit = channel_units(shoe, torque=False)
    std = np.full(2 * count, np.nan)
    if calibration.covariance is not None:
        std = np.sqrt(np.diag(calibration.covariance))
    unknown = np.full(count, np.nan)
    start = np.array([fit.offset for fit in content.cells]) if content.feet else unknown
    columns = [
        IntervalColumn(f"|gain| ({gain_unit})", np.abs(calibration.parameters.gain),
               NORMAL_95 * std[:count], unknown),
        IntervalColumn(f"offset ({unit})", calibration.parameters.offset, NORMAL_95 * std[count:],
               start if len(start) == count else unknown),
    ]  # fmt: skip
    names = [
        name + (" (−)" if gain < 0.0 else "")
        for name, gain in zip(shoe.names, calibration.parameters.gain, strict=True)
    ]
    inverted = bool((calibration.parameters.gain < 0.0).any())
    pictures = [
        Picture(
            "Gains and offsets",
            intervals(names, columns, start="off the shoe"),
            "(−): pressing it lowers its reading." if inverted else "",
        )
    ]
    lines = [
        CellLine(fit.name, fit.masses, fit.residuals)
        for fit in content.cells
        if len(fit.masses) >= LEAST_LOADS
    ]
    for foot, side in enumerate(FEET):
        own = [line for line in lines if shoe.foot[shoe.index(line.label)] == foot]
        if own:
            pictures.append(
                Picture(
                    f"Single cells of the {side} shoe",
                    cell_residuals(own),
                    "Force by each cell's own line, less the weight that stood on it.",
                )
            )
    return tuple(pictures)
