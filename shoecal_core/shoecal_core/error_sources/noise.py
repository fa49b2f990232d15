"""How noisy the signals are, and for how long: from what no smooth cause could explain."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.error_sources.regression import Noise
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.error_sources.signals import AIR, CLOSURE, COP, GRF, PARITY, SIGNALS, TILT
from shoecal_core.samples.samples import Samples

FloatArray = NDArray[np.float64]
MOST_KEEP = 0.97
FEWEST = 10
WHITE = (1.0, -4.0, 6.0, -4.0, 1.0)
"""Shares of samples in a row of whose sum only noise is left that has no memory."""
HALF_WITHIN = 0.6745
"""Standard deviations within which half of all normal numbers lie."""
MODEL_ERRORS = 1.5
"""Of a robot without a fault, times the usual error of a model."""


def least_noise(scene: Scene) -> FloatArray:
    """(s,) noise that no fit may go below.

    A foot that swings pulls at its sensor: what varies there is noise to a model of a foot at
    rest, however small gains would make it. Taken from the first guess of the gains.
    """
    samples = scene.samples
    least = np.zeros(len(SIGNALS))
    here = samples.walks & ~samples.loaded.all(axis=1)
    if here.any():
        owner = np.stack((samples.run, samples.frame), axis=1)[here]
        _, group = np.unique(owner, axis=0, return_inverse=True)
        values = scene.residuals[here, AIR]
        group = group.reshape(-1)
        count = np.bincount(group)[:, None]
        sums = np.stack([np.bincount(group, weights=one) for one in values.T], axis=1)
        least[AIR] = (values - (sums / count)[group]).std(axis=0)
    return least


def with_model_error(scene: Scene, noise: Noise, settings: SignalSettings) -> Noise:
    """With what no model tells: soles that give, legs that brace each other, links that bend.

    As large as if each sole leant by `model_error_rad`, and alike for `model_error_s`: however
    well sensors tell what happens, smaller things than that are not what is looked for.
    """
    samples = scene.samples
    error = model_error(scene, settings)
    step = float(np.median(np.diff(samples.time)[np.diff(samples.segment) == 0]))
    keep = float(np.exp(-step / settings.model_error_s))
    std = np.hypot(noise.std, error)
    return Noise(std, (noise.std**2 * noise.keep + error**2 * keep) / std**2)


def model_error(scene: Scene, settings: SignalSettings) -> FloatArray:
    """(s,) what each signal is off when soles lean by `model_error_rad`."""
    lean = settings.model_error_rad
    height = float(np.median(scene.samples.states.com[:, 0, 2]))
    weight = float(np.median(scene.samples.force))
    error = np.zeros(len(SIGNALS))
    error[GRF] = lean * weight
    error[COP] = lean * height
    error[AIR] = lean * weight * np.array([1.0, 0.1 * height, 0.1 * height])
    error[CLOSURE] = lean * np.array([*(3 * (0.5 * height,)), 1.0, 1.0, 1.0])
    error[PARITY] = 0.2 * lean * weight
    error[TILT] = lean
    return error


def quiet(scene: Scene, settings: SignalSettings) -> FloatArray:
    """(s,) noise that a robot without a fault has at most: of sensors, and of any model.

    What is more may be an effect that nothing known explains: it must not raise the floor that
    it is judged by. Of a robot that walks nothing of the kind can be said.
    """
    if scene.samples.walks.any():
        return np.full(len(SIGNALS), np.inf)
    most: FloatArray = np.hypot(MODEL_ERRORS * model_error(scene, settings), white_noise(scene))
    return most


def white_noise(scene: Scene) -> FloatArray:
    """(s,) standard deviation of what has no memory from sample to sample.

    By fourth differences within segments, which smooth signals do not have; a median, as a jolt
    is no noise either. Zero for a signal that is too short.
    """
    samples = scene.samples
    apart = len(WHITE) - 1
    rows = [slice(at, len(samples.run) - apart + at) for at in range(len(WHITE))]
    there = np.all([scene.mask[one] for one in rows], axis=0)
    there &= (samples.segment[rows[0]] == samples.segment[rows[-1]])[:, None]
    bend = np.sum([share * scene.residuals[one] for share, one in zip(WHITE, rows, strict=True)], 0)
    white: FloatArray = np.array(
        [
            np.median(np.abs(one[here])) / HALF_WITHIN / np.linalg.norm(WHITE)
            if here.any()
            else 0.0
            for one, here in zip(bend.T, there.T, strict=True)
        ]
    )
    return white


def noise_of(samples: Samples, mask: NDArray[np.bool_], rest: FloatArray) -> Noise:
    """From residuals (T, s) under a rich model, where a mask (T, s) lets them count."""
    step = np.diff(samples.time)
    follows = (np.diff(samples.segment) == 0) & (step > 0) & (step < 1.5 * np.median(step))
    std, keep = np.ones(len(SIGNALS)), np.zeros(len(SIGNALS))
    for index in range(len(SIGNALS)):
        there = mask[:, index]
        if np.count_nonzero(there) < FEWEST:
            continue
        own = rest[:, index]
        std[index] = np.sqrt(max(float(np.mean(own[there] ** 2)), 1e-24))
        pair = follows & there[1:] & there[:-1]
        if np.count_nonzero(pair) > FEWEST:
            product = float(np.mean(own[1:][pair] * own[:-1][pair]))
            power = float(np.mean(own[1:][pair] ** 2 + own[:-1][pair] ** 2)) / 2.0
            keep[index] = np.clip(product / max(power, 1e-300), 0.0, MOST_KEEP)
    return Noise(std, keep)
