"""Fitting the CoP correction of each foot inside the combined CoP (paper, eqs. 19 and 20).

The corrected combined CoP is the mean of both feet's corrected CoPs, weighed by their forces.
Each foot's correction is linear in its parameters, so this is one damped linear least squares.
A foot's correction is kept only where it predicts runs it was not fitted to better.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.calibration.stance import Stance
from shoecal_core.sensing.correction import CopCorrection, features
from shoecal_core.sensing.sensing import MINIMUM_FORCE
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import ChannelParameters, cop, foot_wrenches

FloatArray = NDArray[np.float64]
CHOICES: tuple[tuple[int, ...], ...] = ((), (0,), (1,), (0, 1))
MINIMUM_GAIN = 0.05
"""Share by which the error on held-out runs must fall for a foot's correction to be kept."""


class _Piece:
    """One run's samples, with everything the linear problem needs."""

    def __init__(
        self,
        shoe: Shoe,
        parameters: ChannelParameters,
        time_offset: float,
        stance: Stance,
        minimum_force: float,
    ) -> None:
        self.duration = stance.duration
        outputs = parameters.outputs(stance.readings)
        wrenches = foot_wrenches(shoe, outputs)
        self.raw = cop(wrenches, minimum_force)
        keep = np.isfinite(self.raw).all(axis=(1, 2))
        self.raw = self.raw[keep]
        force = wrenches[keep, :, 0]
        share = force / force.sum(axis=1, keepdims=True)
        rotations = (np.eye(2), stance.support.rotation)
        places = np.stack((self.raw[:, 0], stance.support.right_to_left(self.raw[:, 1])), axis=1)
        measured = (share[:, :, None] * places).sum(axis=1)
        reference = stance.cop[keep] + time_offset * stance.cop_rate[keep]
        self.error = reference - measured
        self.outputs = [outputs[keep][:, shoe.of_foot(foot)] for foot in (0, 1)]
        self.rows = []
        for foot in (0, 1):
            in_x, in_y = features(self.raw[:, foot], self.outputs[foot])
            turned = [
                np.hstack((rotations[foot][axis, 0] * in_x, rotations[foot][axis, 1] * in_y))
                for axis in (0, 1)
            ]
            self.rows.append(share[:, foot, None, None] * np.stack(turned, axis=1))


def fit_corrections(
    shoe: Shoe,
    parameters: ChannelParameters,
    time_offset: float,
    stances: Sequence[Stance],
    settings: CalibrationSettings,
) -> tuple[CopCorrection, ...]:
    """Corrections of the feet for which they help; none where they do not.

    With fewer than two runs nothing can be held out, so nothing is corrected.
    """
    pieces: dict[int, list[_Piece]] = {}
    for stance in stances:
        if all(stance.loaded):
            piece = _Piece(shoe, parameters, time_offset, stance, MINIMUM_FORCE)
            if len(piece.error):
                pieces.setdefault(stance.run, []).append(piece)
    if len(pieces) < 2 or settings.correction_std_m == 0.0:
        return ()
    everything = [piece for group in pieces.values() for piece in group]
    errors = {feet: _held_out_error(pieces, feet, settings) for feet in CHOICES}
    best = min(CHOICES, key=lambda feet: errors[feet])
    if errors[best] > (1.0 - MINIMUM_GAIN) * errors[()]:
        return ()
    solution = _solve(everything, best, settings)
    return tuple(_correction(everything, foot, solution[foot]) for foot in best)


def _held_out_error(
    pieces: dict[int, list[_Piece]], feet: tuple[int, ...], settings: CalibrationSettings
) -> float:
    """Mean CoP error over runs, each predicted from the others [m]."""
    errors = []
    for run, held_out in pieces.items():
        others = [piece for other, group in pieces.items() if other != run for piece in group]
        solution = _solve(others, feet, settings)
        for piece in held_out:
            left = piece.error - sum(
                (piece.rows[foot] @ solution[foot] for foot in feet), np.zeros_like(piece.error)
            )
            errors.append(float(np.linalg.norm(left, axis=1).mean()))
    return float(np.mean(errors))


def _solve(
    pieces: Sequence[_Piece], feet: tuple[int, ...], settings: CalibrationSettings
) -> dict[int, FloatArray]:
    """Damped least squares: a term of typical size is expected within `correction_std_m`."""
    if not feet:
        return {}
    matrix = np.concatenate(
        [np.concatenate([piece.rows[foot] for foot in feet], axis=2) for piece in pieces]
    )
    target = np.concatenate([piece.error for piece in pieces])
    matrix = matrix.reshape(-1, matrix.shape[2])
    size = np.sqrt((matrix**2).mean(axis=0))
    size[size == 0.0] = 1.0
    scaled = matrix / size
    samples_as_one = max(1.0, len(matrix) / 2 / _independent(pieces, settings))
    damping = samples_as_one * (settings.cop_std_m / settings.correction_std_m) ** 2
    solution = (
        np.linalg.solve(
            scaled.T @ scaled + damping * np.eye(len(size)), scaled.T @ target.reshape(-1)
        )
        / size
    )
    widths = np.cumsum([pieces[0].rows[foot].shape[2] for foot in feet])[:-1]
    return dict(zip(feet, np.split(solution, widths), strict=True))


def _independent(pieces: Sequence[_Piece], settings: CalibrationSettings) -> float:
    """Number of independent samples behind all of them."""
    return max(1.0, sum(piece.duration for piece in pieces) / settings.correlation_s)


def _correction(pieces: Sequence[_Piece], foot: int, solution: FloatArray) -> CopCorrection:
    raw = np.concatenate([piece.raw[:, foot] for piece in pieces])
    outputs = np.concatenate([piece.outputs[foot] for piece in pieces])
    in_x, in_y = np.split(solution, 2)
    return CopCorrection(
        foot=foot,
        x=in_x,
        y=in_y,
        cop_range=np.stack((raw.min(axis=0), raw.max(axis=0))),
        output_range=np.stack((outputs.min(axis=0), outputs.max(axis=0))),
    )
