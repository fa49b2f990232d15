"""Sums and fits against least squares with whole matrices."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from core.diagnosis.drawn import correlated
from shoecal_core.diagnosis.workspace import Workspace
from shoecal_core.error_sources.regression import Noise, Sums, Whitening, solve
from shoecal_core.error_sources.signals import SIGNALS

FloatArray = NDArray[np.float64]
RUNS, ROWS, BASE, MORE = 5, 40, 3, 4


def dense(seed: int) -> tuple[Sums, FloatArray, FloatArray]:
    """Sums of random columns, with the whole matrix (runs x rows, q) and the prior precision."""
    rng = np.random.default_rng(seed)
    whole = rng.normal(size=(RUNS * ROWS, BASE + MORE + 1))
    whole[:, -1] += whole[:, :-1] @ rng.normal(size=BASE + MORE)
    parts = whole.reshape(RUNS, ROWS, -1)
    products = np.einsum("brp,brq->bpq", parts, parts)
    precision = rng.uniform(0.1, 10.0, BASE)
    runs = tuple(range(1, RUNS + 1))
    return Sums(runs, products, np.full(RUNS, float(ROWS)), BASE, precision), whole, precision


@pytest.mark.parametrize("columns", [(), (0,), (1, 3)])
def test_a_fit_is_least_squares_with_priors(columns: tuple[int, ...]) -> None:
    sums, whole, precision = dense(1)
    std = np.array([0.3, 2.0, 0.1, 1.0])[list(columns)]
    found = solve(sums.of(sums.runs)[0], sums, columns, std)
    matrix = whole[:, [*range(BASE), *(BASE + one for one in columns)]]
    prior = np.diag(np.sqrt(np.concatenate((precision, 1.0 / std**2))))
    stacked, target = np.vstack((matrix, prior)), np.append(whole[:, -1], np.zeros(len(prior)))
    vector = np.linalg.lstsq(stacked, target, rcond=None)[0]
    np.testing.assert_allclose(found.vector, vector, rtol=1e-6)
    np.testing.assert_allclose(found.covariance, np.linalg.inv(stacked.T @ stacked), rtol=1e-6)
    assert found.squares == pytest.approx(float(np.sum((target - stacked @ vector) ** 2)))


def test_runs_add_up_and_are_left_out() -> None:
    sums, whole, _ = dense(2)
    products, rows = sums.of((2, 4))
    chosen = np.vstack((whole[ROWS : 2 * ROWS], whole[3 * ROWS : 4 * ROWS]))
    np.testing.assert_allclose(products, chosen.T @ chosen)
    assert rows == 2 * ROWS
    for left_out, others in zip((2, 4), sums.others((2, 4)), strict=True):
        np.testing.assert_allclose(others, sums.of([6 - left_out])[0])


def test_correlated_noise_becomes_white(workspace: Workspace) -> None:
    rng = np.random.default_rng(3)
    count = len(SIGNALS)
    noise = Noise(np.geomspace(0.1, 10.0, count), np.linspace(0.0, 0.95, count))
    scene = workspace.scene
    white = Whitening(scene.samples, scene.mask, noise)(correlated(noise, workspace, rng))
    follows = np.diff(scene.samples.segment) == 0
    for index in range(count):
        there = scene.mask[:, index]
        own = white[:, index]
        few = 4.0 / np.sqrt(np.count_nonzero(there))
        assert np.mean(own[there] ** 2) == pytest.approx(1.0, abs=1.5 * few)
        pair = follows & there[1:] & there[:-1]
        assert abs(np.mean(own[1:][pair] * own[:-1][pair])) < few
        assert not own[~there].any()
