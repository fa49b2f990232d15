"""What `solve_speed.py` has solved: a session's samples many times over, and the same for scipy."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from population import different_robots, sessions
from shoecal_core.calibration.fit import fit_parameters, prior_of
from shoecal_core.calibration.least_squares import Fit
from shoecal_core.calibration.pipeline import load_data
from shoecal_core.calibration.residuals import Weights
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.estimation.initial_guess import InitialGuess, initial_guess
from shoecal_core.samples.stance import Stance
from shoecal_core.sensing.shoe import Shoe

FloatArray = NDArray[np.float64]
NOISE = 0.01
"""Of the readings, as a share of each channel's standard deviation."""
MEAN_S = 0.25
"""Over which readings are averaged."""


@dataclass(frozen=True)
class Task:
    """What is to be solved."""

    shoe: Shoe
    stances: list[Stance]
    guess: InitialGuess
    settings: CalibrationSettings

    @property
    def samples(self) -> int:
        return sum(len(stance.time) for stance in self.stances)

    @property
    def megabytes(self) -> float:
        """What a solver reads of the samples."""
        arrays = [(s.readings, s.force, s.cop, s.cop_rate) for s in self.stances]
        return sum(array.nbytes for group in arrays for array in group) / 1e6

    def means(self) -> Task:
        """The same of means over MEAN_S."""
        return replace(self, stances=[_averaged(stance) for stance in self.stances])

    def solve(self) -> Fit:
        return fit_parameters(self.shoe, self.stances, self.guess, self.settings)


def make_task(samples: int, seed: int, population: Path) -> Task:
    """A session's runs, repeated until there are enough samples."""
    member = different_robots(seed, population)[-1]
    session = next(session for _, session in sessions([member]))
    data = load_data(session)
    stances = data.of(list(data.stances))
    times = math.ceil(samples / sum(len(stance.time) for stance in stances))
    rng = np.random.default_rng(seed)
    stances = [_repeated(stance, times, rng) for stance in stances]
    return Task(
        data.shoe,
        stances,
        initial_guess(data.shoe, stances, weight_row=False),
        CalibrationSettings(),
    )


def _repeated(stance: Stance, times: int, rng: np.random.Generator) -> Stance:
    count = len(stance.time) * times
    readings = np.tile(stance.readings, (times, 1))
    for channel, size in enumerate(NOISE * stance.readings.std(axis=0)):
        readings[:, channel] += size * rng.standard_normal(count)
    return replace(
        stance,
        time=np.arange(count) * stance.duration / len(stance.time),
        readings=readings,
        force=np.tile(stance.force, times),
        cop=np.tile(stance.cop, (times, 1)),
        cop_rate=np.tile(stance.cop_rate, (times, 1)),
        angles=None,
        efforts=None,
    )


def _averaged(stance: Stance) -> Stance:
    """Means of samples that follow each other; what is left at the end is left out."""
    length = max(1, round(MEAN_S * len(stance.time) / stance.duration))
    count = len(stance.time) // length

    def mean(values: FloatArray) -> FloatArray:
        kept = values[: count * length]
        found: FloatArray = kept.reshape(count, length, *values.shape[1:]).mean(axis=1)
        return found

    return replace(
        stance,
        time=mean(stance.time),
        readings=mean(stance.readings),
        force=mean(stance.force),
        cop=mean(stance.cop),
        cop_rate=mean(stance.cop_rate),
        angles=None,
        efforts=None,
    )


class Rows:
    """All residuals as one vector, for a solver that knows nothing of the problem."""

    def __init__(self, task: Task) -> None:
        settings = task.settings
        prior = prior_of(task.shoe, task.guess, settings)
        self._weights = Weights.of(settings)
        self._stances = task.stances
        self._shares = [math.sqrt(self._weights.of_sample(stance)) for stance in task.stances]
        self._prior = prior
        self._rows = 3 * task.samples + len(prior.mean)

    def __call__(self, vector: FloatArray) -> FloatArray:
        rows = np.empty(self._rows)
        channels = len(vector) // 2
        gain, offset, time_offset = vector[:channels], vector[channels:-1], vector[-1]
        done = 0
        for stance, share in zip(self._stances, self._shares, strict=True):
            count = len(stance.time)
            constant = offset @ stance.columns + stance.base
            force, mx, my = (stance.readings @ (gain[:, None] * stance.columns) + constant).T
            own = rows[done : done + 3 * count].reshape(3, count)
            own[0] = (share / self._weights.force) * (force - stance.force)
            expected = stance.cop + time_offset * stance.cop_rate
            own[1] = (share / self._weights.cop) * (-my / force - expected[:, 0])
            own[2] = (share / self._weights.cop) * (mx / force - expected[:, 1])
            done += 3 * count
        rows[done:] = (vector - self._prior.mean) / self._prior.std
        return rows

    def jacobian(self, vector: FloatArray) -> FloatArray:
        """(rows, 2n + 1) derivatives in closed form."""
        found = np.zeros((self._rows, len(vector)))
        channels = len(vector) // 2
        gain, offset = vector[:channels], vector[channels:-1]
        done = 0
        for stance, share in zip(self._stances, self._shares, strict=True):
            count, columns, readings = len(stance.time), stance.columns, stance.readings
            constant = offset @ columns + stance.base
            force, mx, my = (readings @ (gain[:, None] * columns) + constant).T
            own = found[done : done + 3 * count].reshape(3, count, -1)
            own[0, :, channels:-1] = (share / self._weights.force) * columns[:, 0]
            scale = (share / self._weights.cop / force)[:, None]
            for axis, (lever, place) in enumerate(((-columns[:, 2], -my), (columns[:, 1], mx))):
                own[1 + axis, :, channels:-1] = scale * (
                    lever - (place / force)[:, None] * columns[:, 0]
                )
                own[1 + axis, :, -1] = -(share / self._weights.cop) * stance.cop_rate[:, axis]
            own[:, :, :channels] = own[:, :, channels:-1] * readings
            done += 3 * count
        found[done:] = np.diag(1.0 / self._prior.std)
        return found

    def solve(self, *, analytic: bool) -> FloatArray:
        """As a careful user would: parameters scaled alike.

        By scipy's default method: on this problem none of the others is faster. Without
        derivatives: one call a Jacobian column.
        """
        start, scale = self._prior.mean, self._prior.std
        if analytic:
            found = least_squares(self, start, self.jacobian, x_scale=scale)
        else:
            found = least_squares(self, start, x_scale=scale)
        solution: FloatArray = found.x
        return solution
