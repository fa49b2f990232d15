"""Fitting the CoP correction of each foot inside the combined CoP (paper, eqs. 19 and 20).

The corrected combined CoP is the mean of both feet's corrected CoPs, weighed by their forces.
Each foot's correction is linear in its parameters, so this is one damped linear least squares.
A foot's correction is kept only where it predicts runs it was not fitted to better.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import add

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.estimation.chunks import chunks
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.correction import (
    POLYNOMIAL,
    CopCorrection,
    corrected_channels,
    features,
)
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, cop, foot_wrenches


@dataclass(frozen=True)
class CorrectionSums:
    """Normal equations of some samples, and where these lie.

    Attributes:
        matrix: (p, p) sum of the rows' products.
        right: (p,) sum of the rows' products with the error.
        samples: how many.
        duration: that they stand for [s].
        low, high: (4 + n,) of the raw CoPs, left and right [m], and of the outputs [N or N m].
    """

    matrix: FloatArray
    right: FloatArray
    samples: int
    duration: float
    low: FloatArray
    high: FloatArray

    def __add__(self, other: CorrectionSums) -> CorrectionSums:
        return CorrectionSums(
            self.matrix + other.matrix,
            self.right + other.right,
            self.samples + other.samples,
            self.duration + other.duration,
            np.minimum(self.low, other.low),
            np.maximum(self.high, other.high),
        )


@dataclass(frozen=True)
class _Chunk:
    """m samples in which both feet carry load.

    Attributes:
        place: (m, 4 + n) raw CoPs of the left and of the right foot, outputs.
        share: (m, 2) of the force on each foot.
        rows: (m, 2, p) what each parameter adds to the combined CoP.
        error: (m, 2) what should be added to it [m].
        duration: that they stand for [s].
    """

    place: FloatArray
    share: FloatArray
    rows: FloatArray
    error: FloatArray
    duration: float


class CorrectionEquations:
    """Equations under given gains, offsets and time offset.

    Attributes:
        foot: (p,) whose parameter each is: those in x, then those in y, first the left foot's.
    """

    def __init__(self, shoe: Shoe, parameters: ChannelParameters, time_offset: float) -> None:
        self._shoe = shoe
        self._parameters = parameters
        self._time_offset = time_offset
        self._channels = [corrected_channels(shoe, foot) for foot in (0, 1)]
        self._terms = [POLYNOMIAL + len(channels) for channels in self._channels]
        self.foot = np.repeat((0, 1), 2 * np.array(self._terms))

    def sums(self, stances: Sequence[Stance]) -> CorrectionSums:
        """Sums over all samples of double supports."""
        size, traits = len(self.foot), 4 + len(self._shoe.channels)
        total = CorrectionSums(
            np.zeros((size, size)),
            np.zeros(size),
            0,
            0.0,
            np.full(traits, np.inf),
            np.full(traits, -np.inf),
        )
        for chunk in self._chunks(stances):
            rows = chunk.rows.reshape(-1, size)
            total += CorrectionSums(
                rows.T @ rows,
                rows.T @ chunk.error.reshape(-1),
                len(chunk.error),
                chunk.duration,
                chunk.place.min(axis=0),
                chunk.place.max(axis=0),
            )
        return total

    def errors(self, stances: Sequence[Stance], solutions: FloatArray) -> FloatArray:
        """Mean error of the combined CoP (c, 2) [m] under c solutions (c, p), for each foot: a
        sample counts by the foot's share of the force.
        """
        total, weight = np.zeros((len(solutions), 2)), np.zeros(2)
        for chunk in self._chunks(stances):
            left = chunk.error[:, :, None] - chunk.rows @ solutions.T
            total += np.linalg.norm(left, axis=1).T @ chunk.share
            weight += chunk.share.sum(axis=0)
        return total / weight

    def correction(self, foot: int, solution: FloatArray, sums: CorrectionSums) -> CopCorrection:
        """One foot's correction, of a solution (p,), trained on the samples of `sums`."""
        in_x, in_y = np.split(solution[self.foot == foot], 2)
        ends = np.stack((sums.low, sums.high))
        return CopCorrection(
            foot=foot,
            x=in_x,
            y=in_y,
            cop_range=ends[:, 2 * foot : 2 * foot + 2],
            output_range=ends[:, 4 + self._channels[foot]],
        )

    def _chunks(self, stances: Sequence[Stance]) -> Iterator[_Chunk]:
        for stance in stances:
            if not all(stance.loaded) or not len(stance.time):
                continue
            period = stance.duration / len(stance.time)
            for part in chunks(len(stance.time)):
                chunk = self._chunk(stance, part, period)
                if len(chunk.error):
                    yield chunk

    def _chunk(self, stance: Stance, part: slice, period: float) -> _Chunk:
        outputs = self._parameters.outputs(stance.readings[part])
        wrenches = foot_wrenches(self._shoe, outputs)
        raw = cop(wrenches, MINIMUM_FORCE)
        loaded = np.isfinite(raw).all(axis=(1, 2))
        raw, outputs, force = raw[loaded], outputs[loaded], wrenches[loaded, :, 0]
        share = force / force.sum(axis=1, keepdims=True)
        places = np.stack((raw[:, 0], stance.support.right_to_left(raw[:, 1])), axis=1)
        expected = stance.cop[part] + self._time_offset * stance.cop_rate[part]
        rows = []
        for foot, turn in ((0, np.eye(2)), (1, stance.support.rotation)):
            terms = np.hstack(features(raw[:, foot], outputs[:, self._channels[foot]]))
            turned = terms[:, None, :] * np.repeat(turn, self._terms[foot], axis=1)
            rows.append(share[:, foot, None, None] * turned)
        return _Chunk(
            place=np.hstack((raw.reshape(len(raw), 4), outputs)),
            share=share,
            rows=np.concatenate(rows, axis=2),
            error=expected[loaded] - (share[:, :, None] * places).sum(axis=1),
            duration=period * len(raw),
        )


Feet = tuple[int, ...]
CHOICES: tuple[Feet, ...] = ((), (0,), (1,), (0, 1))
MINIMUM_GAIN = 0.05
"""Share by which a foot's error on held-out runs must fall for its correction to be kept."""


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
    if settings.correction_std_m == 0.0:
        return ()
    equations = CorrectionEquations(shoe, parameters, time_offset)
    runs: dict[int, list[Stance]] = {}
    for stance in stances:
        runs.setdefault(stance.run, []).append(stance)
    sums = {run: equations.sums(group) for run, group in runs.items()}
    sums = {run: found for run, found in sums.items() if found.samples}
    if len(sums) < 2:
        return ()
    errors = []
    for run in sums:
        others = reduce(add, (found for other, found in sums.items() if other != run))
        solutions = [_solve(others, np.isin(equations.foot, feet), settings) for feet in CHOICES]
        errors.append(equations.errors(runs[run], np.array(solutions)))
    feet = _best(dict(zip(CHOICES, np.mean(errors, axis=0), strict=True)))
    total = reduce(add, sums.values())
    solution = _solve(total, np.isin(equations.foot, feet), settings)
    return tuple(equations.correction(foot, solution, total) for foot in feet)


def _best(errors: Mapping[Feet, FloatArray]) -> Feet:
    """The feet to correct: each is the better for its correction, and the other no worse.

    Args:
        errors: (2,) by choice, on held-out runs: while the left foot, the right foot carries [m].
    """

    def helps(feet: Feet, foot: int) -> bool:
        found, without = errors[feet], errors[tuple(other for other in feet if other != foot)]
        lower = found[foot] <= (1.0 - MINIMUM_GAIN) * without[foot]
        return bool(lower and found[1 - foot] <= without[1 - foot])

    good = [feet for feet in CHOICES if all(helps(feet, foot) for foot in feet)]
    return min(good, key=lambda feet: float(errors[feet].sum()))


def _solve(sums: CorrectionSums, fitted: BoolArray, settings: CalibrationSettings) -> FloatArray:
    """Parameters (p,) by damped least squares, zero where they are not `fitted` (p,).

    A term of typical size is expected within `correction_std_m`.
    """
    matrix, right = sums.matrix[np.ix_(fitted, fitted)], sums.right[fitted]
    size = np.sqrt(np.diag(matrix) / (2 * sums.samples))
    size[size == 0.0] = 1.0
    samples_as_one = max(1.0, sums.samples / max(1.0, sums.duration / settings.correlation_s))
    damping = samples_as_one * (settings.cop_std_m / settings.correction_std_m) ** 2
    scaled = matrix / np.outer(size, size) + damping * np.eye(len(size))
    solution = np.zeros(len(fitted))
    solution[fitted] = np.linalg.solve(scaled, right / size) / size
    return solution
