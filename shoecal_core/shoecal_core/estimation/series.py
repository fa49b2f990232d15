"""How far measured GRF and CoP are off a reference."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.truth import Truth
from shoecal_core.samples.stance import Stance
from shoecal_core.shoe.sensing import Measured, Sensing
from shoecal_core.shoe.shoe import FEET


@dataclass(frozen=True)
class Mae:
    """A mean absolute error.

    Attributes:
        mean, std: of the absolute error; NaN where nothing could be compared.
        count: samples compared.
        left_out: samples that could not be, since one side had no value: an unloaded foot.
    """

    mean: float
    std: float
    count: int
    left_out: int = 0


def grf_mae(measured: FloatArray, reference: FloatArray) -> Mae:
    """MAE of forces (T,) [N] (paper, eq. 7); what is not finite is left out and counted."""
    return _mae(np.abs(measured - reference))


def cop_mae(measured: FloatArray, reference: FloatArray) -> Mae:
    """MAE of CoPs (T, 2) [m]: mean Euclidean norm (paper, eq. 8); NaN is left out and counted."""
    return _mae(np.linalg.norm(measured - reference, axis=-1))


def _mae(error: FloatArray) -> Mae:
    finite = error[np.isfinite(error)]
    left_out = len(error) - len(finite)
    if not len(finite):
        return Mae(float("nan"), float("nan"), 0, left_out)
    return Mae(float(finite.mean()), float(finite.std()), len(finite), left_out)


@dataclass(frozen=True)
class Errors:
    """Errors over some runs.

    Attributes:
        grf, cop: of both feet together [N, m].
        foot_grf, foot_cop: left, right; NaN without samples or reference.
    """

    grf: Mae
    cop: Mae
    foot_grf: tuple[Mae, Mae]
    foot_cop: tuple[Mae, Mae]

    def figures(self) -> dict[str, tuple[Mae, float, str]]:
        """Each by its name in result files, with its scale there and its unit."""
        found = {"grf": (self.grf, 1.0, "n"), "cop": (self.cop, 1e3, "mm")}
        for foot, grf, cop in zip(FEET, self.foot_grf, self.foot_cop, strict=True):
            found[f"{foot}_grf"] = (grf, 1.0, "n")
            found[f"{foot}_cop"] = (cop, 1e3, "mm")
        return found

    def to_json(self) -> dict[str, float]:
        """Figures by their names in result files [N, mm].

        A figure without samples is left out; where samples had to be left out of one, their
        number is given as well.
        """
        found: dict[str, float] = {}
        for name, (mae, scale, unit) in self.figures().items():
            if mae.count:
                found[f"{name}_mae_{unit}"] = scale * mae.mean
                found[f"{name}_std_{unit}"] = scale * mae.std
                found[f"{name}_samples"] = mae.count
            if mae.count and mae.left_out:
                found[f"{name}_samples_left_out"] = mae.left_out
        return found


@dataclass(frozen=True)
class Series:
    """GRF and CoP of T samples, for errors and plots.

    Attributes:
        time: (T,) [s].
        grf: (T,) of both feet [N].
        cop: (T, 2) of both feet in the stance's frame [m].
        foot_grf: (T, 2) [N].
        foot_cop: (T, 2, 2) each in its own sole frame [m].
    """

    time: FloatArray
    grf: FloatArray
    cop: FloatArray
    foot_grf: FloatArray
    foot_cop: FloatArray


def measured_series(sensing: Sensing, stance: Stance) -> Series:
    """What calibrated shoes say."""
    measured = sensing.measure(stance.readings)
    return Series(
        stance.time,
        measured.total_grf,
        _stance_cop(measured, stance),
        measured.grf,
        measured.cop,
    )


def modelled_series(stance: Stance) -> Series:
    """What the model says; of each foot only while the other one is in the air."""
    count = len(stance.time)
    force, place = np.full((count, 2), np.nan), np.full((count, 2, 2), np.nan)
    if stance.hanging is not None:
        standing = 1 - stance.hanging
        force[:, standing], force[:, stance.hanging] = stance.force, 0.0
        place[:, standing] = stance.cop
    return Series(stance.time, stance.force, stance.cop, force, place)


def truth_series(truth: Truth, stance: Stance) -> Series:
    """What the simulator knows, at the stance's times."""

    def at(values: FloatArray) -> FloatArray:
        flat = values.reshape(len(values), -1)
        columns = [np.interp(stance.time, truth.time, column) for column in flat.T]
        return np.stack(columns, axis=1).reshape(len(stance.time), *values.shape[1:])

    # The truth of both feet is in the left sole's frame, a left foot in the air or not.
    place = truth.foot_cop[:, 1] if stance.hanging == 0 else truth.cop
    return Series(
        stance.time,
        at(truth.foot_grf).sum(axis=1),
        at(place),
        at(truth.foot_grf),
        at(truth.foot_cop),
    )


def errors(pairs: Sequence[tuple[Series, Series]]) -> Errors:
    """Errors of the first of each pair against the second, over all samples of all pairs."""

    def joined(name: str) -> tuple[FloatArray, FloatArray]:
        one, other = (
            np.concatenate([getattr(pair[side], name) for pair in pairs]) for side in (0, 1)
        )
        return one, other

    foot_grf, foot_grf_reference = joined("foot_grf")
    foot_cop, foot_cop_reference = joined("foot_cop")
    left, right = (
        (
            grf_mae(foot_grf[:, foot], foot_grf_reference[:, foot]),
            cop_mae(foot_cop[:, foot], foot_cop_reference[:, foot]),
        )
        for foot in (0, 1)
    )
    return Errors(
        grf=grf_mae(*joined("grf")),
        cop=cop_mae(*joined("cop")),
        foot_grf=(left[0], right[0]),
        foot_cop=(left[1], right[1]),
    )


def _stance_cop(measured: Measured, stance: Stance) -> FloatArray:
    if all(stance.loaded):
        return measured.combined_cop(stance.support)
    return measured.cop[:, stance.loaded.index(True)]
