"""Columns of old and sluggish readings are what readings show that are."""

from __future__ import annotations

import numpy as np
import pytest

from core.error_sources.altered import with_forces
from core.error_sources.shows import assert_shows, shape, told
from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.effects.places import all_channels_at
from shoecal_core.error_sources.effects.timing import DELAYS, LAGS, MEANS, Latency, LowPass
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import AIR
from shoecal_core.samples.filters import low_passed
from shoecal_core.samples.samples import Track

PLACES = ("left", "right", "all")


def late(signal_model: SignalModel, place: str, delay: float) -> SignalModel:
    """As if the readings of a place came a delay [s] later."""
    channels = all_channels_at(signal_model, (place,))

    def work(track: Track, force: FloatArray) -> FloatArray:
        after = force.copy()
        for channel in channels:
            after[:, channel] = np.interp(track.time - delay, track.time, force[:, channel])
        return after

    return with_forces(signal_model, work)


@pytest.mark.parametrize("place", PLACES)
def test_latency(signal_model: SignalModel, place: str) -> None:
    delay = 0.06
    found = told(shape(signal_model, Latency(), place), delay)
    assert_shows(signal_model, late(signal_model, place, delay), found, within=0.15)


@pytest.mark.parametrize(("form", "delay"), enumerate(DELAYS))
def test_each_form_is_of_its_delay(signal_model: SignalModel, form: int, delay: float) -> None:
    """But for a foot that is lifted while the other one's readings are late."""
    found = list(Latency().shapes(signal_model, ("left",)))[form]
    least, most = found.within["delay"]
    assert least < delay < most
    after = late(signal_model, "left", delay)
    assert_shows(signal_model, after, told(found, delay), within=0.35, without=AIR)


@pytest.mark.parametrize(("form", "time"), list(enumerate(LAGS))[1:])
def test_each_form_is_of_its_two_lags(signal_model: SignalModel, form: int, time: float) -> None:
    channels = all_channels_at(signal_model, ("left",))

    def work(track: Track, force: FloatArray) -> FloatArray:
        lagging = force.copy()
        for _ in range(2):
            lagging[:, channels] = low_passed(lagging[:, channels], track.time, 0.5 * time)
        return lagging

    found = list(LowPass().shapes(signal_model, ("left",)))[form]
    after = with_forces(signal_model, work)
    assert_shows(signal_model, after, told(found, time), within=0.35, without=AIR)


@pytest.mark.parametrize(("form", "time"), list(enumerate(MEANS, len(LAGS))))
def test_each_form_is_of_its_running_means(
    signal_model: SignalModel, form: int, time: float
) -> None:
    channels = all_channels_at(signal_model, ("left",))

    def work(track: Track, force: FloatArray) -> FloatArray:
        averaged, step = force.copy(), np.median(np.diff(track.time))
        width = 1 + round(2.0 * time / 3.0 / step)
        for _ in range(3):
            before = np.repeat(averaged[:1, channels], width - 1, axis=0)
            sums = np.cumsum(np.vstack((before, averaged[:, channels])), axis=0)
            sums = np.vstack((np.zeros(sums.shape[1]), sums))
            averaged[:, channels] = (sums[width:] - sums[:-width]) / width
        return averaged

    found = list(LowPass().shapes(signal_model, ("left",)))[form]
    after = with_forces(signal_model, work)
    assert_shows(signal_model, after, told(found, time), within=0.35, without=AIR)


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
