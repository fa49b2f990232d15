"""Is a calibration accurate enough? Errors in per cent of the weight and of a foot's half width.

Errors are counted against the model, and a walk's model is poor: it misses accelerations within a
step. How much of an error any calibration could win is seen from how far sensor and model move
together: what the best linear map from a foot's channels to the model's wrench still leaves belongs
to the model (or to noise), whatever gains and offsets are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.checks import Finding
from shoecal_core.calibration.evaluate import Errors
from shoecal_core.model.robot import Robot
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.shoe import FEET

FloatArray = NDArray[np.float64]

GRF_WARN, GRF_FAIL = 0.02, 0.05
"""Mean absolute error of the GRF, over the weight."""
COP_WARN, COP_FAIL = 0.25, 0.5
"""The same of the CoP, over half the width of the narrower foot's sensing polygon."""
MODEL_SHARE = 0.5
"""The model is the limit where it leaves at least this share of the error."""
LEAST_SAMPLES = 100
"""Of one kind of stance from which the limit is taken."""


@dataclass(frozen=True)
class ModelLimit:
    """What no calibration can win against a walk's model.

    Attributes:
        grf, cop: mean absolute errors that the best linear map leaves [N, m].
        together: correlation of the CoP that it measures with the model's, within stances.
    """

    grf: float
    cop: float
    together: float

    def to_json(self) -> dict[str, float]:
        """For result files [N, mm]."""
        return {
            "grf_mae_n": self.grf,
            "cop_mae_mm": 1e3 * self.cop,
            "cop_correlation": self.together,
        }


def model_limit(stances: Sequence[Stance]) -> ModelLimit | None:
    """The limit over some stances; None where the robot stands, or there are too few samples."""
    force, place, pairs = [], [], []
    for loaded in ((True, True), (True, False), (False, True)):
        kind = [one for one in stances if one.loaded == loaded and not one.quasi_static]
        if sum(len(one.time) for one in kind) < LEAST_SAMPLES:
            continue
        wanted = np.concatenate([one.reference for one in kind])
        shown = np.concatenate([_shown(one) for one in kind])
        rows = np.hstack((shown, np.ones((len(shown), 1))))
        mapped = rows @ np.linalg.lstsq(rows, wanted, rcond=1e-9)[0]
        expected = np.concatenate([one.cop for one in kind])
        best = np.stack((-mapped[:, 2], mapped[:, 1]), axis=1) / mapped[:, :1]
        force.append(np.abs(mapped[:, 0] - wanted[:, 0]))
        place.append(np.linalg.norm(best - expected, axis=1))
        edges = np.cumsum([len(one.time) for one in kind])[:-1]
        pairs += [
            np.stack((a - a.mean(axis=0), b - b.mean(axis=0)))
            for a, b in zip(np.split(best, edges), np.split(expected, edges), strict=True)
        ]
    if not force:
        return None
    ours, model = np.concatenate(pairs, axis=1)
    together = float((ours * model).sum() / np.sqrt((ours**2).sum() * (model**2).sum()))
    return ModelLimit(
        float(np.concatenate(force).mean()), float(np.concatenate(place).mean()), together
    )


def check_accuracy(
    label: str, errors: Errors, robot: Robot, limit: ModelLimit | None = None
) -> list[Finding]:
    """Errors of both feet together, and of each foot where they are known.

    Args:
        label: of the runs.
        errors: of measured against modelled GRF and CoP.
        robot: for its weight and its feet.
        limit: of the model; None for a robot that stands.
    """
    width = min(foot.half_width for foot in robot.feet)
    figures = [("GRF", errors.grf), ("CoP", errors.cop)]
    for foot, grf, cop in zip(FEET, errors.foot_grf, errors.foot_cop, strict=True):
        parts = ((f"{foot} foot's GRF", grf), (f"{foot} foot's CoP", cop))
        figures += [(name, mae) for name, mae in parts if mae.count]
    findings = []
    for name, mae in figures:
        force = name.endswith("GRF")
        warn, fail = (GRF_WARN, GRF_FAIL) if force else (COP_WARN, COP_FAIL)
        share = mae.mean / (robot.weight if force else width)
        if share <= warn:
            continue
        scale, unit = (1.0, "N") if force else (1e3, "mm")
        level, most = ("WARN", warn) if share <= fail else ("FAIL", fail)
        told = (
            f"{name} is {scale * mae.mean:.2f} {unit} off its model on {label} runs, {share:.1%} "
            f"of {'the weight' if force else 'half the width of a foot'} (limit {most:.0%})"
        )
        left = None if limit is None else limit.grf if force else limit.cop
        if limit is not None and left is not None and left >= MODEL_SHARE * mae.mean:
            level = "WARN"
            told += (
                ": the model of the walk, not the sensor, is the limit: the best linear map of the "
                f"readings leaves {scale * left:.2f} {unit} (within steps the CoP of sensor and "
                f"model move together with r = {limit.together:.2f}); judge the sensor by slow "
                "motions in double support"
            )
        else:
            told += ": check the robot's weight, the shoe file and that nothing touched the robot"
        findings.append(Finding(level, told))
    return findings


def _shown(stance: Stance) -> FloatArray:
    """(T, k) what sensors show of a stance: the standing foot's channels, or both feet's wrench."""
    if all(stance.loaded):
        return stance.readings @ stance.columns
    return stance.readings[:, np.any(stance.columns != 0.0, axis=1)]
