"""Results of a manual calibration for machines."""

from __future__ import annotations

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.manual.calibrate import (
    CellsCalibration,
    FootResult,
    ManualCalibration,
)
from shoecal_core.shoe.shoe import FEET


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
