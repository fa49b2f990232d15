"""Fitting the CoP correction of each foot inside the combined CoP (paper, eqs. 19 and 20).

The corrected combined CoP is the mean of both feet's corrected CoPs, weighed by their forces.
Each foot's correction is linear in its parameters, so this is one damped linear least squares.
A foot's correction is kept only where it predicts runs it was not fitted to better.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray

from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.correction_equations import CorrectionEquations, CorrectionSums
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

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


def _solve(
    sums: CorrectionSums, fitted: NDArray[np.bool_], settings: CalibrationSettings
) -> FloatArray:
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
