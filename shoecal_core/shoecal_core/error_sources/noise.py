"""How noisy the signals are, and for how long: from what no smooth cause could explain."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter, median_filter, minimum_filter

from shoecal_core.arrays import BoolArray, FloatArray
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.signals import AIR, CLOSURE, COP, GRF, PARITY, SIGNALS, TILT
from shoecal_core.samples.samples import Samples

WHITE = (1.0, -4.0, 6.0, -4.0, 1.0)
"""Shares of samples in a row of whose sum only noise is left that has no memory."""
HALF_WITHIN = 0.6745
"""Standard deviations within which half of all normal numbers lie."""
WALKING = 30.0
"""Times the errors of a model of a robot that stands: dynamics are predicted far worse."""
JOLT_S, JOLT_STDS = 1.0, 10.0
"""A jolt is over within half of this, and is so many times what usually is that short."""


def least_noise(signal_model: SignalModel) -> FloatArray:
    """(s,) noise that no fit may go below, in the signals' units.

    A foot that swings pulls at its sensor: what varies there is noise to a model of a foot at
    rest, however small gains would make it. Taken from the first guess of the gains.
    """
    samples = signal_model.samples
    least = np.zeros(len(SIGNALS))
    here = samples.walks & ~samples.loaded.all(axis=1)
    if here.any():
        owner = np.stack((samples.run, samples.frame), axis=1)[here]
        _, group = np.unique(owner, axis=0, return_inverse=True)
        values = signal_model.residuals[here, AIR]
        group = group.reshape(-1)
        count = np.bincount(group)[:, None]
        sums = np.stack([np.bincount(group, weights=one) for one in values.T], axis=1)
        least[AIR] = (values - (sums / count)[group]).std(axis=0)
    return least


def model_error(signal_model: SignalModel, settings: SignalSettings) -> FloatArray:
    """(s,) what each signal is off when soles lean by `model_error_rad`, in its unit."""
    lean = settings.model_error_rad
    height = float(np.median(signal_model.samples.states.com[:, 0, 2]))
    weight = float(np.median(signal_model.samples.force))
    error = np.zeros(len(SIGNALS))
    error[GRF] = lean * weight
    error[COP] = lean * height
    error[AIR] = lean * weight * np.array([1.0, 0.1 * height, 0.1 * height])
    error[CLOSURE] = lean * np.array([*(3 * (0.5 * height,)), 1.0, 1.0, 1.0])
    error[PARITY] = 0.2 * lean * weight
    error[TILT] = lean
    return error


def form_error(signal_model: SignalModel, settings: SignalSettings) -> FloatArray:
    """(s,) what is not modelled of each signal, in its unit: more where the robot walks."""
    error = model_error(signal_model, settings)
    return np.maximum(error, WALKING * error) if signal_model.samples.walks.any() else error


def colour(samples: Samples, frequency: FloatArray, settings: SignalSettings) -> FloatArray:
    """(G,) variance of a coefficient at frequencies [Hz], of noise of first order.

    It varies by one, and stays alike for `correlation_s`.
    """
    step = float(np.median(np.diff(samples.time)[np.diff(samples.segment) == 0]))
    keep = settings.correlation_s
    found: FloatArray = 2.0 * keep / step / (1.0 + (2.0 * np.pi * frequency * keep) ** 2)
    return found


def white_noise(signal_model: SignalModel) -> FloatArray:
    """(s,) standard deviation of what has no memory from sample to sample, in the signals' units.

    By fourth differences within segments, which smooth signals do not have; a median, as a jolt
    is no noise either. Zero for a signal that is too short.
    """
    samples = signal_model.samples
    apart = len(WHITE) - 1
    rows = [slice(at, len(samples.run) - apart + at) for at in range(len(WHITE))]
    there = np.all([signal_model.mask[one] for one in rows], axis=0)
    there &= (samples.segment[rows[0]] == samples.segment[rows[-1]])[:, None]
    bend = np.sum(
        [share * signal_model.residuals[one] for share, one in zip(WHITE, rows, strict=True)], 0
    )
    white: FloatArray = np.array(
        [
            np.median(np.abs(one[here])) / HALF_WITHIN / np.linalg.norm(WHITE)
            if here.any()
            else 0.0
            for one, here in zip(bend.T, there.T, strict=True)
        ]
    )
    return white


def jolts(signal_model: SignalModel, settings: SignalSettings) -> BoolArray:
    """(T, s) values far off their median over a second: a knock is no error of a robot.

    Nor is a foot that is put down in a walk, which is not looked at.
    """
    samples, rest = signal_model.samples, signal_model.residuals
    found = np.zeros(rest.shape, dtype=np.bool_)
    if samples.walks.any():
        return found
    least = np.maximum(form_error(signal_model, settings), white_noise(signal_model))
    for segment in np.unique(samples.segment):
        here = np.flatnonzero(samples.segment == segment)
        step = float(np.median(np.diff(samples.time[here]))) if len(here) > 1 else JOLT_S
        size = 2 * round(0.5 * JOLT_S / step) + 1
        usual = median_filter(rest[here], (size, 1), mode="nearest")
        # Halfway up a step is not off.
        low, high = (
            one(usual, (size, 1), mode="nearest") for one in (minimum_filter, maximum_filter)
        )
        away = np.maximum(rest[here] - high, low - rest[here]).clip(0.0)
        spread = np.median(np.abs(rest[here] - usual), axis=0) / HALF_WITHIN
        found[here] = away > JOLT_STDS * np.maximum(spread, least)
    return found & signal_model.mask
