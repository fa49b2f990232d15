"""What counts as noise: no jolt, and nothing that only a fault can make."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from core.error_sources.altered import bearing, with_readings
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.scene import Scene
from shoecal_core.error_sources.signals import COP, SIGNALS
from shoecal_core.samples.samples import Track

FloatArray = NDArray[np.float64]
SETTINGS = DiagnosisSettings()


def again(workspace: Workspace, scene: Scene) -> Workspace:
    """The same runs of another scene."""
    return make_workspace(scene, EFFECTS, workspace.train, workspace.test, SETTINGS)


def test_a_jolt_counts_for_nothing(workspace: Workspace) -> None:
    """A tenth of the weight more for two tenths of a second in a training run."""
    scene = workspace.scene
    run = workspace.train[2]
    jolt = 20.0

    def jolted(track: Track) -> FloatArray:
        readings = track.readings.copy()
        if track.run == run:
            here = np.abs(track.time - jolt) < 0.1
            readings[here] += 0.1 * scene.samples.robot.weight / 8.0 / scene.parameters.gain
        return readings

    after = again(workspace, with_readings(scene, jolted))
    samples = after.scene.samples
    near = (samples.run == run) & (np.abs(samples.time - jolt) < 0.3)
    assert after.scene.outliers[near, 0].any()
    assert after.scene.outliers.mean() < 0.02
    assert after.noise.std[0] < 1.3 * workspace.noise.std[0]
    assert not after.scene.outliers[np.isin(samples.run, after.test)].any()


def test_what_nothing_explains_does_not_raise_the_floor(workspace: Workspace) -> None:
    """The CoP goes to and fro by itself, as when something swings on the robot."""
    scene = workspace.scene
    swing = 0.004 * np.sin(2.0 * np.pi * scene.samples.time / 1.9)
    cop = scene.cop + np.stack((swing, np.zeros_like(swing)), axis=1)
    after = again(workspace, bearing(scene, cop))
    axis = SIGNALS.index("cop_x")
    assert after.noise.std[axis] > 3.0 * workspace.noise.std[axis]
    assert (after.floor[COP] < 1.5 * workspace.floor[COP]).all()
    assert after.beyond_all[axis] > 3.0 * workspace.beyond_all[axis]


def test_the_floor_of_a_robot_without_a_fault_is_its_noise(workspace: Workspace) -> None:
    assert (workspace.floor <= workspace.beyond_all).all()
    np.testing.assert_array_less(0.6 * workspace.beyond_all[COP], workspace.floor[COP])
