"""Cosine coefficients of stances: what they keep of signals, and how noise stands in them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.signal import lfilter

from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.noise import colour
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signals import CLOSURE, SIGNALS
from shoecal_core.error_sources.spectrum import BANDS, BandTransform, frequencies_of
from shoecal_core.error_sources.whitening import Whitening


def test_a_transform_keeps_lengths_and_angles(workspace: Workspace) -> None:
    signal_model = workspace.signal_model
    values = np.where(
        signal_model.mask, np.random.default_rng(1).normal(size=(3, *signal_model.mask.shape)), 0.0
    )
    turned = BandTransform(signal_model.samples, signal_model.mask)(values)
    for signal in range(len(SIGNALS)):
        np.testing.assert_allclose(
            turned[..., signal] @ turned[..., signal].T,
            values[..., signal] @ values[..., signal].T,
            atol=1e-9,
        )


def test_a_constant_of_each_stance_is_one_coefficient(workspace: Workspace) -> None:
    signal_model = workspace.signal_model
    samples = signal_model.samples
    course = np.where(signal_model.mask, (1.0 + samples.segment)[:, None], 0.0)
    turned = BandTransform(samples, signal_model.mask)(course)
    for segment in np.unique(samples.segment):
        own = turned[samples.segment == segment]
        assert (np.count_nonzero(np.abs(own) > 1e-9, axis=0) <= 1).all()


def test_white_noise_is_white_in_every_band(workspace: Workspace) -> None:
    signal_model = workspace.signal_model
    rng = np.random.default_rng(2)
    std = np.geomspace(0.1, 10.0, len(SIGNALS))
    whitening = Whitening(
        signal_model.samples, signal_model.mask, np.tile(std[:, None] ** 2, BANDS)
    )
    noise = np.where(signal_model.mask, std * rng.normal(size=signal_model.mask.shape), 0.0)
    white = whitening(noise)
    assert not white[~whitening.kept].any()
    for group in np.unique(whitening.spectrum.group[whitening.kept]):
        own = white[whitening.kept & (whitening.spectrum.group == group)]
        assert np.mean(own**2) == pytest.approx(1.0, abs=5.0 * np.sqrt(2.0 / len(own)))


def test_noise_that_stays_alike_has_its_colour(workspace: Workspace) -> None:
    samples = workspace.signal_model.samples
    settings = SignalSettings()
    step = float(np.median(np.diff(samples.time)[np.diff(samples.segment) == 0]))
    keep = float(np.exp(-step / settings.correlation_s))
    rng = np.random.default_rng(3)
    drive = rng.normal(size=(200, len(samples.run))) * np.sqrt(1.0 - keep**2)
    noise = lfilter([1.0], [1.0, -keep], drive, axis=1)
    spectrum = BandTransform(samples, workspace.signal_model.mask)
    values = np.zeros((200, *workspace.signal_model.mask.shape))
    values[:, :, CLOSURE] = noise[:, :, None]
    turned = spectrum(np.where(workspace.signal_model.mask, values, 0.0))
    signal = CLOSURE.start
    told = []
    for band in range(1, BANDS):
        here = spectrum.kept[:, signal] & (spectrum.group[:, signal] == signal * BANDS + band)
        told.append(np.mean(turned[:, here, signal] ** 2))
    wanted = colour(samples, frequencies_of(signal * BANDS + np.arange(1, BANDS)), settings)
    np.testing.assert_allclose(told, wanted, rtol=0.35)
