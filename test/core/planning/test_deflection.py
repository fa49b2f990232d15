from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from core.planning.bodies import load_body
from core.planning.motions import SETTINGS
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import JointDeflection
from shoecal_core.planning.deflection import deflected, with_sag
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.support_phase import SupportPhase

ROBOT = load_body("nao").robot


def test_a_joint_gives_way_to_its_load() -> None:
    positions = np.tile(ROBOT.posture, (3, 1))
    torques = np.zeros((3, len(ROBOT.legs)))
    limit = ROBOT.effort_limit[ROBOT.legs]
    torques[1, 3], torques[2, 3] = limit[3], -0.5 * limit[3]
    moved = (deflected(ROBOT, positions, torques) - positions)[:, ROBOT.legs[3]]
    sag, play = ROBOT.deflection.sag, ROBOT.deflection.play
    np.testing.assert_allclose(moved, [0.0, -sag - play / 2.0, 0.5 * sag + play / 2.0], atol=1e-9)


def test_a_stiff_robot_is_where_it_shall_be() -> None:
    stiff = dataclasses.replace(ROBOT, deflection=JointDeflection(sag=0.0, play=0.0))
    torques = np.ones((1, len(ROBOT.legs)))
    assert np.array_equal(deflected(stiff, ROBOT.posture[None], torques)[0], ROBOT.posture)


@pytest.mark.parametrize("phase", [SupportPhase.LEFT, SupportPhase.RIGHT])
def test_what_sag_takes_is_added(phase: SupportPhase) -> None:
    meant = FootPose.of(DoubleSupport(0.0, -0.12, 0.0))
    lower = -0.004 if phase is SupportPhase.LEFT else 0.004
    true = FootPose(meant.rotation, meant.translation + np.array([0.0, 0.003, lower]))
    found = with_sag(ROBOT, SETTINGS, [(meant, meant), (meant, true)], phase)
    assert found.step_lift == pytest.approx(SETTINGS.step_lift + 0.004)
    assert found.step_clearance == pytest.approx(SETTINGS.step_clearance + 0.003)
    assert with_sag(ROBOT, SETTINGS, [(true, meant)], phase) == SETTINGS
