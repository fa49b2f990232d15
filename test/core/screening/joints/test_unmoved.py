"""An arm that stays while its angle is reported to move."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from shoecal_core.estimation.session_data import SessionData, load_data
from shoecal_core.recording.session import Session
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.blocks import blocks
from shoecal_core.screening.joints.unmoved import Unmoved, describe_unmoved, unmoved_joint
from shoecal_core.screening.rough_fit import Statics
from shoecal_core.screening.settings import CalibrationSettings

SETTINGS = CalibrationSettings()
RUNS = (1, 2, 3, 4)
ARM = "LShoulderPitch"
PERIOD_S, SWING_RAD = 13.0, 1.0


@pytest.fixture(scope="module")
def data(standard_session: Session) -> SessionData:
    return load_data(standard_session, RUNS)


def with_swing(data: SessionData) -> dict[int, Aligned]:
    """The arm is said to swing, and stays."""
    joint = data.robot.joint_names.index(ARM)
    swung = {}
    for run, one in data.aligned.items():
        angles = one.joint_angles.copy()
        angles[:, joint] += 0.5 * SWING_RAD * (1.0 - np.cos(2.0 * np.pi * one.time / PERIOD_S))
        swung[run] = replace(one, joint_angles=angles, states=data.kinematics.states(angles))
    return swung


def found(data: SessionData, runs: Mapping[int, Aligned]) -> Unmoved | None:
    return unmoved_joint(runs, data.shoe, data.kinematics, SETTINGS)


def test_an_arm_that_stays_is_named(data: SessionData) -> None:
    assert found(data, data.aligned) is None
    one = found(data, with_swing(data))
    assert one is not None
    assert one.joint == ARM
    assert one.share == pytest.approx(1.0, abs=3.0 * one.std)
    (finding,) = describe_unmoved(one)
    assert finding.verdict == "FAIL"
    assert finding.reason.startswith(f"{ARM} does not move as its angles say")


def test_an_arm_that_moves_is_not(data: SessionData) -> None:
    shoe, weight = data.shoe, data.robot.weight
    parts = {run: blocks(one, shoe) for run, one in data.aligned.items()}
    gain = Statics.of(shoe, parts, weight, SETTINGS).fit.parameters.gain
    moving = {}
    for run, one in with_swing(data).items():
        shift = one.states.com[:, 0, :2] - data.aligned[run].states.com[:, 0, :2]
        wrench = weight * np.stack((np.zeros(len(shift)), shift[:, 1], -shift[:, 0]), axis=1)
        outputs = wrench @ np.linalg.pinv(parts[run].columns)
        moving[run] = replace(one, readings=one.readings + outputs / gain)
    assert found(data, moving) is None
