"""What counts as noise: what has no memory; and what counts for nothing, a jolt."""

from __future__ import annotations

import numpy as np

from core.error_sources.altered import bearing, with_readings
from shoecal_core.arrays import FloatArray
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.noise import jolts, white_noise
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.samples.samples import Track

SETTINGS = DiagnosisSettings()


def again(workspace: Workspace, signal_model: SignalModel) -> Workspace:
    """The same runs of another signal_model."""
    return make_workspace(
        signal_model, EFFECTS, workspace.train, workspace.test, SETTINGS, Tolerances()
    )


def test_a_jolt_counts_for_nothing(workspace: Workspace) -> None:
    """A tenth of the weight more for two tenths of a second in a training run."""
    signal_model = workspace.signal_model
    run = workspace.train[2]
    jolt = 10.0

    def jolted(track: Track) -> FloatArray:
        readings = track.readings.copy()
        if track.run == run:
            here = np.abs(track.time - jolt) < 0.1
            readings[here] += (
                0.1 * signal_model.samples.robot.weight / 8.0 / signal_model.parameters.gain
            )
        return readings

    after = again(workspace, with_readings(signal_model, jolted))
    samples = after.signal_model.samples
    near = (samples.run == run) & (np.abs(samples.time - jolt) < 0.3)
    assert after.signal_model.outliers[near, 0].any()
    assert after.signal_model.outliers.mean() < 0.02
    assert (after.noise[0] < 1.3 * workspace.noise[0]).all()
    assert not after.signal_model.outliers[np.isin(samples.run, after.test)].any()


def test_a_step_is_no_jolt(workspace: Workspace) -> None:
    """A cell's zero that jumps in the midst of a run is an error to be found."""
    signal_model = workspace.signal_model

    def stepped(track: Track) -> FloatArray:
        readings = track.readings.copy()
        if track.run == workspace.train[1]:
            readings[track.time > 20.0, 0] += 2.0 / signal_model.parameters.gain[0]
        return readings

    after = with_readings(signal_model, stepped)
    assert np.abs(after.residuals - signal_model.residuals).max() > 1.0
    assert not jolts(after, SETTINGS).any()


def test_noise_without_memory_is_told_from_what_drifts(workspace: Workspace) -> None:
    """The CoP swings slowly, and cells are noisy: only the latter is white."""
    signal_model = workspace.signal_model
    rng = np.random.default_rng(3)
    swing = 0.004 * np.sin(2.0 * np.pi * signal_model.samples.time / 9.0)
    white = 0.001 * rng.standard_normal(len(swing))
    found = white_noise(bearing(signal_model, signal_model.cop + np.stack((swing, white), axis=1)))
    before = white_noise(signal_model)
    assert found[1] < 1.2 * before[1] + 1e-5
    assert np.hypot(before[2], 0.0008) < found[2] < np.hypot(before[2], 0.0012)
