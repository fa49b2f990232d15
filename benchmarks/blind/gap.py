"""How large a set's gap is: errors on its test runs after a plain calibration on its others.

Not the diagnosis' own measure: the affine fit of the paper, nothing left out, no CoP correction,
and no offset in time, which a calibration would else take for granted. The cells' noise is taken
off, and that of a usual set put in its place: it differs by a factor of 300 from set to set.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from blind.felt import Felt
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.fit import fit_parameters
from shoecal_core.estimation.initial_guess import initial_guess
from shoecal_core.estimation.residuals import unpack
from shoecal_core.estimation.series import errors, measured_series, modelled_series
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording.session import Session
from shoecal_core.recording.train_test import split_runs
from shoecal_core.samples.stance import Stance
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.sensing import Sensing

_NO_OFFSET_S = 1e-6
_EVERY = 5
"""Samples are similar to their neighbours."""
_MM_PER_N = 10.0
"""Error of CoP that counts as much as one of GRF, about as their floors."""


@dataclass(frozen=True)
class MeasuredGap:
    """Mean absolute errors on the test runs: CoP [mm], GRF [N].

    Attributes:
        cop_mm, grf_n: without the cells' own noise, which is not the same in every set.
        cop_noise_mm, grf_noise_n: what that noise alone makes.
    """

    cop_mm: float
    grf_n: float
    cop_noise_mm: float = 0.0
    grf_noise_n: float = 0.0

    @classmethod
    def told(cls, made: Mapping[str, Any]) -> MeasuredGap:
        """From what is kept of a set; the noise of sets made long ago was not told by itself."""
        names = [one.name for one in dataclasses.fields(cls)]
        return cls(**{name: made[name] for name in names if name in made})

    def over(self, floor: MeasuredGap) -> float:
        """The larger of both over the floor's, each beside the floor's noise."""
        cop, grf = floor.with_noise
        return max(
            math.hypot(self.cop_mm, floor.cop_noise_mm) / cop,
            math.hypot(self.grf_n, floor.grf_noise_n) / grf,
        )

    def largest(self, floor: MeasuredGap) -> float:
        """The larger of both over the floor's, noise left out of either."""
        return max(self.cop_mm / floor.cop_mm, self.grf_n / floor.grf_n)

    @property
    def with_noise(self) -> tuple[float, float]:
        """Errors of CoP [mm] and GRF [N] as they are read."""
        return (
            math.hypot(self.cop_mm, self.cop_noise_mm),
            math.hypot(self.grf_n, self.grf_noise_n),
        )


@dataclass(frozen=True)
class AddedNoise:
    """Noise that was added to a session's cells, of any colour.

    Attributes:
        time: by run, (T,) since its start [s].
        readings: by run, (T, n) that were added.
        alone: errors that it makes by itself.
    """

    time: Mapping[int, FloatArray]
    readings: Mapping[int, FloatArray]
    alone: MeasuredGap

    def taken_off(self, stance: Stance) -> Stance:
        """A stance as cells without noise would have read it."""
        time, added = self.time[stance.run], self.readings[stance.run].T
        own = np.stack([np.interp(stance.time, time, one) for one in added], axis=1)
        return dataclasses.replace(stance, readings=stance.readings - own)


def measure_gap(session: Session, noise: AddedNoise, also: Sequence[int] = ()) -> MeasuredGap:
    """Fit the runs that are marked to train, and look at the ones marked to test.

    Args:
        session: of the set.
        noise: that was added, and is taken off again.
        also: runs to look at besides, each by itself: where something happens once. The larger
            errors count.
    """
    settings = dataclasses.replace(CalibrationSettings(), time_offset_std_s=_NO_OFFSET_S)
    train, test = split_runs(session, (), ())
    data = load_data(session, (*train, *test))
    training = [noise.taken_off(one) for one in data.of(train)]
    guess = initial_guess(data.shoe, training, weight_row=False)
    parameters, _ = unpack(fit_parameters(data.shoe, training, guess, settings).vector)
    sensing = Sensing(data.shoe, parameters)
    found = []
    for runs in (test, *([run] for run in also)):
        stances = [noise.taken_off(one) for one in data.of(runs)]
        left = errors([(measured_series(sensing, one), modelled_series(one)) for one in stances])
        found.append((1e3 * left.cop.mean, left.grf.mean))
    cop, grf = np.max(found, axis=0).tolist()
    return MeasuredGap(cop, grf, noise.alone.cop_mm, noise.alone.grf_n)


def gap_of_change(felt: Felt, change: FloatArray) -> MeasuredGap:
    """What a change of forces makes of the errors on test runs once gains and offsets are refitted.

    To first order: changes of GRF and CoP are linear in those of forces, and so is what gains and
    offsets can take away.

    Args:
        felt: before the change.
        change: (T, n) of the forces [N].
    """
    rows = slice(None, None, _EVERY)
    forces, columns = felt.forces[rows], felt.columns[rows]
    load, about_x, about_y = np.einsum("tn,tnw->wt", forces, columns)[:, :, None]
    grf = columns[:, :, 0]
    cop_x = (-columns[:, :, 2] + about_y / load * grf) / load
    cop_y = (columns[:, :, 1] - about_x / load * grf) / load
    signals = np.stack((grf * _MM_PER_N, 1e3 * cop_x, 1e3 * cop_y))
    base = np.concatenate((signals * forces, signals), axis=2)
    target = np.einsum("stn,tn->st", signals, change[rows])
    training = felt.training[rows]
    own = base[:, training].reshape(-1, base.shape[2])
    fitted = np.linalg.lstsq(own, target[:, training].ravel(), rcond=None)[0]
    left = (target - base @ fitted)[:, ~training]
    return MeasuredGap(
        float(np.hypot(left[1], left[2]).mean()), float(np.abs(left[0]).mean()) / _MM_PER_N
    )


def floor_of(gaps: list[MeasuredGap]) -> MeasuredGap:
    """What clean sets have, in the median."""
    table = np.array([dataclasses.astuple(gap) for gap in gaps])
    return MeasuredGap(*np.median(table, axis=0).tolist())
