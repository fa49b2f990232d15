"""How large a set's gap is: errors on its test runs after a plain calibration on its others.

Not the diagnosis' own measure: the affine fit of the paper, nothing left out, no CoP correction,
and no offset in time, which a calibration would else take for granted.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from shoecal_core.calibration.evaluate import errors, measured_series, modelled_series
from shoecal_core.calibration.fit import fit_parameters
from shoecal_core.calibration.initial_guess import initial_guess
from shoecal_core.calibration.pipeline import load_data, split_runs
from shoecal_core.calibration.residuals import unpack
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.recording.session import Session
from shoecal_core.sensing.sensing import Sensing

_NO_OFFSET_S = 1e-6


@dataclass(frozen=True)
class MeasuredGap:
    """Mean absolute errors on the test runs: CoP [mm], GRF [N]."""

    cop_mm: float
    grf_n: float

    def over(self, floor: MeasuredGap) -> float:
        """The larger of both, over the floor's."""
        return max(self.cop_mm / floor.cop_mm, self.grf_n / floor.grf_n)


def measure_gap(session: Session) -> MeasuredGap:
    """Fit the runs that are marked to train, and look at the ones marked to test."""
    settings = dataclasses.replace(CalibrationSettings(), time_offset_std_s=_NO_OFFSET_S)
    train, test = split_runs(session, (), ())
    data = load_data(session, (*train, *test))
    training = data.of(train)
    guess = initial_guess(data.shoe, training, weight_row=False)
    parameters, _ = unpack(fit_parameters(data.shoe, training, guess, settings).vector)
    sensing = Sensing(data.shoe, parameters)
    pairs = [(measured_series(sensing, one), modelled_series(one)) for one in data.of(test)]
    found = errors(pairs)
    return MeasuredGap(1e3 * found.cop.mean, found.grf.mean)


def floor_of(gaps: list[MeasuredGap]) -> MeasuredGap:
    """What clean sets have, in the median."""
    return MeasuredGap(
        float(np.median([gap.cop_mm for gap in gaps])),
        float(np.median([gap.grf_n for gap in gaps])),
    )
