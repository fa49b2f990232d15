"""A run with a known weight is told from a model that carries it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from core.diagnosis.rewritten import resampled, rewritten
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.samples.known_weight import KNOWN_MASS, WEIGHTED


def weighted_second(run: Run) -> Run:
    short = resampled(run, 50.0, 12.0)
    if run.info.run == 1:
        return short
    return replace(short, info=replace(run.info, motion=WEIGHTED))


def test_the_weight_counts_in_its_run_alone(standard_session: Session, tmp_path: Path) -> None:
    session = rewritten(standard_session, tmp_path / "session", (1, 2), weighted_second)
    samples = load_data(session, (1, 2)).whole_samples(DiagnosisSettings())
    robot, loaded = samples.robot, samples.run == 2
    np.testing.assert_allclose(samples.force[~loaded], robot.weight)
    np.testing.assert_allclose(samples.force[loaded], robot.weight + KNOWN_MASS * GRAVITY)
    usual = Kinematics(robot).states(samples.angles).com
    np.testing.assert_array_equal(samples.states.com[~loaded], usual[~loaded])
    # Masses are in balance about the common CoM: the weight hangs on the base's origin.
    moved = (samples.states.com - usual)[loaded, 0]
    left = samples.states
    base = -np.einsum("tji,tj->ti", left.left_rotation, left.left_translation)[loaded]
    total = robot.mass + KNOWN_MASS
    np.testing.assert_allclose(moved, KNOWN_MASS / total * (base - usual[loaded, 0]), atol=1e-12)
