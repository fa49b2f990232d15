"""Effects of time: readings that are old, or sluggish."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from shoecal_core.error_sources.base import Component, Place, Shape
from shoecal_core.error_sources.effects import places
from shoecal_core.error_sources.effects.load_cell import shown
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.samples.filters import slope
from shoecal_core.samples.samples import Track

FloatArray = NDArray[np.float64]
TYPICAL_LAG = 0.1
"""s; the second of two lags counts with the square of their time, taken at this one."""

STAMPS = 0.003
"""s; how far apart joints and readings may truly be that bear the same stamp."""


class Latency:
    """Readings are older than their stamps say, against the joints."""

    identifier, group = "latency", "timing"
    components = (Component("delay", "s", 0.04, 0.0, form=1.5, blur=STAMPS, as_built="delay_s"),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Each foot, or both alike."""
        return places.feet_and_all(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """What was read, less what comes a delay later, for several delays (to second order)."""
        channels = places.all_channels_at(signal_model, place)
        for delay in (0.02, 0.1):

            def work(track: Track, delay: float = delay) -> FloatArray:
                force = signal_model.parameters.outputs(track.readings)[:, channels]
                rate = slope(force, track.time)
                return -rate - 0.5 * delay * slope(rate, track.time)

            yield Shape(
                ("delay",),
                shown(signal_model, channels, signal_model.samples.decimated(work))[None],
            )


class LowPass:
    """Readings follow the force with a lag of first order."""

    identifier, group = "low_pass", "timing"
    components = (Component("time", "s", 0.08, 0.0, form=1.5, blur=STAMPS),)

    def places(self, signal_model: SignalModel) -> Iterator[Place]:
        """Each foot, or both alike."""
        return places.feet_and_all(signal_model)

    def shapes(self, signal_model: SignalModel, place: Place) -> Iterator[Shape]:
        """One lag, for which the force is reading + time x rate; or two, of half the time each."""
        channels = places.all_channels_at(signal_model, place)
        for second in (0.0, 0.25 * TYPICAL_LAG):

            def work(track: Track, second: float = second) -> FloatArray:
                rate = slope(
                    signal_model.parameters.outputs(track.readings)[:, channels], track.time
                )
                return -rate - second * slope(rate, track.time)

            yield Shape(
                ("time",), shown(signal_model, channels, signal_model.samples.decimated(work))[None]
            )
