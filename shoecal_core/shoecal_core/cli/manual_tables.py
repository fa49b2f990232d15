"""Results of a manual calibration, for a terminal and for machines."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from shoecal_core.cli.tables import new_table
from shoecal_core.estimation.assessment import NORMAL_95
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.series import Mae
from shoecal_core.manual.calibrate import (
    CellsCalibration,
    FootResult,
    ManualCalibration,
)
from shoecal_core.report.quantities import size, uncertain
from shoecal_core.shoe.shoe import FEET


def cells_table(result: CellsCalibration, unit: str) -> Table:
    """One row a cell; ± is half of the 95 % interval, as in the report."""
    table = new_table("Single cells (± half of the 95 % interval)")
    for name in ("", "gain", "offset", "about its line"):
        table.add_column(name, justify="right" if name else "left", no_wrap=True)
    for fit in result.cells:
        gain, offset = NORMAL_95 * np.sqrt(np.diag(fit.covariance))
        table.add_row(
            fit.name,
            uncertain(fit.gain, gain, f"N/{unit}"),
            uncertain(fit.offset, offset, "N"),
            size(1e3 * fit.residual_std, "mN"),
        )
    return table


def manual_table(result: ManualCalibration) -> Table:
    """One row a shoe: MAE and its standard deviation."""
    table = new_table("Under known weights")
    for name in ("", "loads", "GRF (N)", "CoP before (mm)", "CoP after (mm)", "held out (mm)"):
        table.add_column(name, justify="right" if name else "left", no_wrap=True)
    for foot in result.feet:
        cop = foot.cop
        errors = (None, None, None) if cop is None else (cop.before, cop.after, cop.held_out)
        table.add_row(
            FEET[foot.loads.foot],
            str(len(foot.loads.loads)),
            _mae(foot.grf, 1.0, 3),
            *("no CoP" if mae is None else _mae(mae, 1e3, 2) for mae in errors),
        )
    return table


def cells_to_json(result: CellsCalibration) -> dict[str, object]:
    """Figures of the first step."""
    figures = _calibration(result.calibration)
    scatter = {fit.name: fit.residual_std if len(fit.masses) > 2 else None for fit in result.cells}
    return {**figures, "residual_std_n": scatter}


def manual_to_json(result: ManualCalibration) -> dict[str, object]:
    """Figures of a manual calibration."""
    feet = {FEET[foot.loads.foot]: _foot(foot) for foot in result.feet}
    return {**_calibration(result.calibration), "manual": feet}


def _calibration(calibration: Calibration) -> dict[str, object]:
    parameters = calibration.parameters
    return {
        "format": 1,
        "verdict": calibration.verdict,
        "reasons": list(calibration.reasons),
        "channels": {
            name: {"gain": float(gain), "offset_n": float(offset)}
            for name, gain, offset in zip(
                calibration.channels, parameters.gain, parameters.offset, strict=True
            )
        },
    }


def _foot(foot: FootResult) -> dict[str, object]:
    figures: dict[str, object] = {
        "loads": len(foot.loads.loads),
        "shift_n": foot.shift.tolist(),
        "grf_mae_n": foot.grf.mean,
        "grf_std_n": foot.grf.std,
    }
    for name in ("before", "after", "held_out"):
        mae = None if foot.cop is None else getattr(foot.cop, name)
        figures |= {
            f"cop_{name}_mm": None if mae is None else 1e3 * mae.mean,
            f"cop_{name}_std_mm": None if mae is None else 1e3 * mae.std,
        }
    return figures


def _mae(mae: Mae, scale: float, digits: int) -> str:
    return f"{mae.mean * scale:.{digits}f} ± {mae.std * scale:.{digits}f}"
