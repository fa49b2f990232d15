from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ros.bodies import nao
from shoecal_core.arrays import FloatArray
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.planner.tilt import Tilt, angle_between, upward

UP = np.array([0.0, 0.0, 1.0])
small = st.floats(-0.3, 0.3)


def leaned(pitch: float, roll: float) -> FloatArray:
    """The floor's upward direction as a torso sees it that leans so."""
    up: FloatArray = Rotation.from_euler("yx", [pitch, roll]).inv().apply(UP)
    return up


@given(small, small)
def test_angles_between_directions(pitch: float, roll: float) -> None:
    cosine = np.cos(pitch) * np.cos(roll)
    assert np.cos(angle_between(UP, leaned(pitch, roll))) == pytest.approx(cosine, abs=1e-12)


@given(small, small, st.floats(-0.03, 0.03), st.floats(-0.03, 0.03))
def test_a_torso_that_follows_the_plan_is_not_tilted(
    pitch: float, roll: float, mounted: float, slope: float
) -> None:
    sensor = Rotation.from_euler("yx", [mounted, slope])
    tilt = Tilt(sensor.apply(UP), UP)
    assert tilt.usable
    meant = leaned(pitch, roll)
    # What the smallest turn at the begin does not tell is of second order.
    assert tilt.error(sensor.apply(meant), meant) < 0.3 * (abs(mounted) + abs(slope)) + 1e-9


@given(st.floats(0.02, 0.3), small)
def test_leaning_beyond_the_plan_is_told_in_full(beyond: float, meant: float) -> None:
    tilt = Tilt(UP, UP)
    assert tilt.error(leaned(meant + beyond, 0.0), leaned(meant, 0.0)) == pytest.approx(beyond)


def test_a_sensor_of_other_axes_is_not_used() -> None:
    assert not Tilt(-UP, UP).usable
    assert not Tilt(np.array([1.0, 0.0, 0.0]), UP).usable


@pytest.mark.parametrize("foot", [0, 1])
def test_the_floor_seen_from_the_base(foot: int) -> None:
    kinematics, angles = Kinematics(nao()), nao().posture.copy()
    upright = upward(kinematics.states(angles[None]), foot)
    np.testing.assert_allclose(upright, UP, atol=1e-6)
    ankle = "LAnklePitch" if foot == 0 else "RAnklePitch"
    angles[nao().joint(ankle)] += 0.1
    turned = upward(kinematics.states(angles[None]), foot)
    assert angle_between(upright, turned) == pytest.approx(0.1, abs=1e-9)
    np.testing.assert_allclose(upward(kinematics.states(angles[None]), 1 - foot), UP, atol=1e-6)
