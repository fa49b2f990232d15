"""What a foot's sensors read while it hangs in the air: its zeros, run by run.

A foot in the air carries nothing, so its channels and the parts below them make no force: what they
show is the zero of that run. Zeros change when sensors are switched on again or warm up. A
calibration that was made with other ones is applied with a run's own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NotRequired, TypedDict

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters, weight_below

EDGE_S = 0.04
"""Cut from both ends of each stretch in the air: there the foot is just leaving or landing."""
LEAST_PHASE_S = 0.1
"""A foot that is in the air for a shorter time does not count."""
INDEPENDENT = 16.0
"""What a foot's motion adds recurs in every swing: its mean over all of them is no better known
than from so many samples."""
NORMAL_95 = 1.96
SINGULAR = 1e-9


@dataclass(frozen=True)
class Zero:
    """One foot of one run in the air, T samples of it.

    Attributes:
        run: its number.
        foot: index into FEET.
        phase: (T,) number of the stretch in the air that each sample is of.
        readings: (T, n) of all channels, of which its own count.
    """

    run: int
    foot: int
    phase: IntArray
    readings: FloatArray

    @property
    def reading(self) -> FloatArray:
        """(n,) means of the raw readings."""
        return np.asarray(self.readings.mean(axis=0))

    @property
    def reading_std(self) -> FloatArray:
        """(n,) their standard deviations."""
        return self._std(self.readings)

    def wrench(self, shoe: Shoe, parameters: ChannelParameters) -> FloatArray:
        """(T, 3) force and moments that it shows in the air, where there are none [N, N m]."""
        columns = np.where((shoe.foot == self.foot)[:, None], shoe.columns, 0.0)
        shown: FloatArray = parameters.outputs(self.readings) @ columns
        shown += weight_below(shoe)[self.foot]
        return shown

    def force(self, shoe: Shoe, parameters: ChannelParameters) -> tuple[float, float]:
        """Vertical force that it shows in the air, and its standard deviation [N]."""
        shown = self.wrench(shoe, parameters)[:, :1]
        return float(shown.mean()), float(self._std(shown)[0])

    def _std(self, values: FloatArray) -> FloatArray:
        """(k,) standard deviations of the means of values (T, k)."""
        count = int(self.phase.max()) + 1
        means = np.stack([values[self.phase == one].mean(axis=0) for one in range(count)])
        variance = np.var(values - means[self.phase], axis=0) / INDEPENDENT
        if count > 1:
            variance = variance + np.var(means, axis=0, ddof=1) / count
        return np.asarray(np.sqrt(variance))


def zeros_of_run(run: int, time: FloatArray, readings: FloatArray, air: BoolArray) -> list[Zero]:
    """Zeros of each foot that is in the air for long enough.

    Args:
        run: number.
        time: (T,) [s].
        readings: (T, n).
        air: (T, 2) the foot is in the air.
    """
    found = []
    for foot in range(len(FEET)):
        marked = np.flatnonzero(air[:, foot])
        phases = np.split(marked, np.flatnonzero(np.diff(marked) > 1) + 1)
        inner = [_inner(one, time) for one in phases if len(one)]
        long = [one for one in inner if len(one) and np.ptp(time[one]) >= LEAST_PHASE_S]
        if long:
            number = np.repeat(np.arange(len(long)), [len(one) for one in long])
            found.append(Zero(run, foot, number, readings[np.concatenate(long)]))
    return found


def _inner(samples: IntArray, time: FloatArray) -> IntArray:
    first, last = time[samples[0]] + EDGE_S, time[samples[-1]] - EDGE_S
    return np.asarray(samples[(time[samples] >= first) & (time[samples] <= last)])


def data_sheet(shoe: Shoe, foot: int) -> ChannelParameters | None:
    """Gains of the data sheets and no offsets; None where a vertical gain of the foot is not known.

    Channels without one have a gain of 0.
    """
    known = [
        channel.nominal_gain is not None
        for channel in shoe.channels
        if channel.foot == foot and channel.vertical
    ]
    if not known or not all(known):
        return None
    sign = np.where(shoe.polarity != 0, shoe.polarity, 1)
    gain = np.array([abs(channel.nominal_gain or 0.0) for channel in shoe.channels])
    return ChannelParameters(sign * gain, np.zeros(len(gain)))


def with_own_zeros(
    shoe: Shoe, parameters: ChannelParameters, zeros: Sequence[Zero]
) -> ChannelParameters:
    """Parameters under which the feet show no wrench in the air, by the least change of offsets.

    Args:
        shoe: with the columns of the calibration.
        parameters: of the calibration.
        zeros: of one run; a foot without keeps its offsets.
    """
    offset = parameters.offset.copy()
    for zero in zeros:
        own = shoe.of_foot(zero.foot)
        shown = zero.wrench(shoe, parameters).mean(axis=0)
        offset[own] -= np.linalg.pinv(shoe.columns[own].T, rcond=SINGULAR) @ shown
    return ChannelParameters(parameters.gain, offset)


class ZeroFigures(TypedDict):
    """A zero in result files.

    `fz_n`: vertical force that the foot shows in the air, by the gains of the data sheets without
    offsets; without data sheets by the calibration [N]. `ci95`: its interval. `left_n`: what the
    calibration leaves of it.
    """

    run: int
    foot: str
    fz_n: float
    ci95: list[float]
    left_n: NotRequired[float]


def zeros_json(
    shoe: Shoe, zeros: Sequence[Zero], parameters: ChannelParameters | None = None
) -> list[ZeroFigures]:
    """The figures of each zero; a foot without data sheets has none without `parameters`."""
    found = []
    for zero in zeros:
        law = data_sheet(shoe, zero.foot) or parameters
        if law is None:
            continue
        shown, std = zero.force(shoe, law)
        half = NORMAL_95 * std
        one = ZeroFigures(
            run=zero.run, foot=FEET[zero.foot], fz_n=shown, ci95=[shown - half, shown + half]
        )
        if parameters is not None:
            one["left_n"] = zero.force(shoe, parameters)[0]
        found.append(one)
    return found
