"""Columns of old and sluggish readings are what readings show that are."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from core.error_sources.altered import with_forces
from core.error_sources.shows import assert_shows, shape, told
from shoecal_core.error_sources.effects.places import all_channels_at
from shoecal_core.error_sources.effects.timing import Latency, LowPass
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.samples.samples import Track

FloatArray = NDArray[np.float64]
PLACES = ("left", "right", "all")


@pytest.mark.parametrize("place", PLACES)
def test_latency(signal_model: SignalModel, place: str) -> None:
    delay = 0.06
    channels = all_channels_at(signal_model, (place,))

    def work(track: Track, force: FloatArray) -> FloatArray:
        late = force.copy()
        for channel in channels:
            late[:, channel] = np.interp(track.time - delay, track.time, force[:, channel])
        return late

    after = with_forces(signal_model, work)
    assert_shows(
        signal_model, after, told(shape(signal_model, Latency(), place), delay), within=0.15
    )


@pytest.mark.parametrize("place", PLACES)
def test_low_pass(signal_model: SignalModel, place: str) -> None:
    constant = 0.08
    channels = all_channels_at(signal_model, (place,))

    def work(track: Track, force: FloatArray) -> FloatArray:
        lagging = force.copy()
        keep = np.exp(-np.diff(track.time) / constant)
        for index, share in enumerate(keep, 1):
            before, now = lagging[index - 1, channels], force[index, channels]
            lagging[index, channels] = share * before + (1.0 - share) * now
        return lagging

    after = with_forces(signal_model, work)
    assert_shows(
        signal_model, after, told(shape(signal_model, LowPass(), place), constant), within=0.15
    )


def test_a_late_reading_lacks_what_has_come_since(signal_model: SignalModel) -> None:
    """While the load rises, old readings are too small."""
    track = signal_model.samples.tracks[0]
    force = signal_model.outputs[track.samples]
    rising = np.gradient(force[:, 0], signal_model.samples.time[track.samples])
    parity = shape(signal_model, Latency(), "left").columns[0][track.samples]
    per_force = (
        signal_model.planes[0]
        @ np.gradient(force, signal_model.samples.time[track.samples], axis=0).T
    )
    assert np.abs(rising).max() > 1.0
    assert parity[:, 12] @ per_force <= 0.0
