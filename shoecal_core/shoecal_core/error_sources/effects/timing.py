"""Effects of time: readings that are old, or sluggish."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.base import Component, Place, Shape
from shoecal_core.error_sources.effects import places
from shoecal_core.error_sources.effects.load_cell import shown
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.samples.filters import rise, slope
from shoecal_core.samples.samples import Track

DELAYS = {0.02: (0.0, 0.06), 0.1: (0.04, 0.2), 0.25: (0.1, 0.5), 0.5: (0.2, 1.0)}
"""s; each with the delays between which its form holds."""
LAGS = {0.0: (0.0, np.inf), 0.1: (0.04, 0.2), 0.25: (0.1, 0.5), 0.5: (0.2, 1.0)}
"""s; the same of two lags together, of half the time each; at 0 it is one lag."""
MEANS = {time: LAGS[time] for time in (0.1, 0.25, 0.5)}
"""s; the same of running means one after the other."""
MEANS_SPREAD = 0.1
"""Variance of the times over which they average, over the square of their mean: 1/9 of three means,
1/12 of four; 1 of a lag, 1/2 of two lags. Converters of load cells average so (sinc filters)."""
STAMPS = 0.003
"""s; how far apart joints and readings may truly be that bear the same stamp."""


class Latency:
    """Readings are older than their stamps say, against the joints."""

    identifier, group = "latency", "timing"
    components = (Component("delay", "s", 0.08, 0.0, form=1.5, blur=STAMPS, as_built="delay_s"),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Each foot, or both alike."""
        return places.feet_and_all(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """What was read, less what comes a delay later, for several delays, in proportion."""
        channels = places.all_channels_at(signal_model, place)
        for delay, bounds in DELAYS.items():

            def work(track: Track, delay: float = delay) -> FloatArray:
                force = signal_model.parameters.outputs(track.readings)[:, channels]
                return -rise(slope(force, track.time), track.time, delay) / delay

            columns = shown(signal_model, channels, signal_model.samples.decimated(work))[None]
            yield Shape(("delay",), columns, within={"delay": bounds})


class LowPass:
    """Readings follow the force with a lag."""

    identifier, group = "low_pass", "timing"
    components = (Component("time", "s", 0.08, 0.0, form=1.5, blur=STAMPS),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Each foot, or both alike."""
        return places.feet_and_all(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """One lag, for which the force is reading + time x rate; two, of half the time each; or
        running means, which are nearly a delay.
        """
        channels = places.all_channels_at(signal_model, place)

        def rate_of(track: Track) -> FloatArray:
            return slope(signal_model.parameters.outputs(track.readings)[:, channels], track.time)

        def lagging(track: Track, time: float) -> FloatArray:
            rate = rate_of(track)
            return -rate - 0.25 * time * slope(rate, track.time)

        def averaged(track: Track, time: float) -> FloatArray:
            rate = rate_of(track)
            spread = 0.5 * MEANS_SPREAD * time * slope(rate, track.time)
            return spread - rise(rate, track.time, time) / time

        for work, forms in ((lagging, LAGS), (averaged, MEANS)):
            for time, bounds in forms.items():
                read = signal_model.samples.decimated(partial(work, time=time))
                columns = shown(signal_model, channels, read)[None]
                yield Shape(("time",), columns, within={"time": bounds})
