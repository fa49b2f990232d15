"""Joint angles that come in coarse steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from core.screening.recordings import SETTINGS, WEIGHT, recording
from shoecal_core.recording.run import JointSamples, Run
from shoecal_core.screening.faults import Fault
from shoecal_core.screening.joints.angle_steps import coarse_step, describe_steps, without_motion
from shoecal_core.screening.joints.legs import Legs
from shoecal_core.screening.screen import screen
from shoecal_core.screening.verdict import Finding

JOINTS = ("hip", "knee", "ankle")


def moved(step: float, *, joints: int = 3) -> list[Run]:
    """Runs in which three joints sway, the first ones of them in steps [rad]."""
    runs = []
    for number, run in recording().runs.items():
        time = run.joints.time
        angles = 0.2 * np.sin(0.4 * time[:, None] + number + np.arange(3))
        if step:
            angles[:, :joints] = np.round(angles[:, :joints] / step) * step
        runs.append(replace(run, joints=JointSamples(time, JOINTS, angles, None)))
    return runs


@pytest.mark.parametrize("step", [0.01, 0.0175, 0.1])
def test_few_digits_are_refused_with_their_step(step: float) -> None:
    found = coarse_step(moved(step), JOINTS, SETTINGS)
    assert found == pytest.approx(step)
    (finding,) = describe_steps(found, SETTINGS)
    assert finding.verdict == "FAIL"
    assert f"{1e3 * step:.3g} mrad" in finding.reason


@pytest.mark.parametrize("degrees", [300.0, 360.0])
def test_servos_of_ten_bits_are_served_with_a_warning(degrees: float) -> None:
    found = coarse_step(moved(np.radians(degrees) / 2**10), JOINTS, SETTINGS)
    assert [one.verdict for one in describe_steps(found, SETTINGS)] == ["WARN"]


@pytest.mark.parametrize("step", [0.0, 0.001, 2.0 * np.pi / 2**12])
def test_usual_encoders_are_fine(step: float) -> None:
    assert coarse_step(moved(step), JOINTS, SETTINGS) == 0.0
    assert not describe_steps(0.0, SETTINGS)


def test_one_coarse_joint_or_one_that_stands_still_is_none() -> None:
    assert coarse_step(moved(0.01, joints=1), JOINTS, SETTINGS) == 0.0
    assert coarse_step(recording().runs.values(), ("joint",), SETTINGS) == 0.0


def test_steps_are_told_in_place_of_motion() -> None:
    motion = Finding("WARN", "run 1 moved too fast", Fault.TOO_FAST)
    assert without_motion([motion, *describe_steps(0.005, SETTINGS)]) == tuple(
        describe_steps(0.005, SETTINGS)
    )
    whole = recording()
    found = screen(whole.runs, whole.aligned, whole.shoe, WEIGHT, SETTINGS, legs=Legs(step=0.01))
    assert [one.fault for one in found.findings] == [Fault.COARSE_ANGLES]
