"""The tables of a manual calibration's report."""

from __future__ import annotations

import math

import numpy as np

from shoecal_core.estimation.assessment import NORMAL_95
from shoecal_core.report.manual_content import ManualReport
from shoecal_core.report.page import Table
from shoecal_core.report.quantities import (
    UNKNOWN,
    channel_units,
    mean_error,
    quantity,
    size,
    uncertain,
)
from shoecal_core.shoe.shoe import FEET


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
        ("", "loads", "GRF", "CoP before", "CoP after", "CoP, each load from the others"),
        rows,
        "MAE ± standard deviation. The last column is what to expect of loads that were not read: "
        "there the correction knows all loads but the one that it predicts.",
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
