"""Joints that run out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.bodies import nao
from shoecal_ros.adapters.deceleration_profile import DecelerationProfile

TIME_S = 0.4
SHARES = st.floats(0.0, 1.0)


@given(SHARES, st.floats(-6.0, 6.0), st.floats(0.0, 1.0))
def test_joints_slow_down_evenly_within_their_limits(
    place: float, speed: float, elapsed: float
) -> None:
    robot = nao()
    begun = robot.lower + place * (robot.upper - robot.lower)
    coast = DecelerationProfile.within_limits(robot, begun, np.full_like(begun, speed), TIME_S)
    angles, speeds = coast.at(elapsed)
    assert (angles >= robot.lower - 1e-8).all()
    assert (angles <= robot.upper + 1e-8).all()
    assert (abs(speeds) <= abs(speed)).all()
    # v^2 / 2 s, where the limit leaves no more way than s; else the whole time.
    free = np.minimum(begun - robot.lower, robot.upper - begun) > 0.5 * abs(speed) * TIME_S
    assert angles[free] == pytest.approx(
        (begun + speed * (t := min(elapsed, TIME_S)) * (1.0 - 0.5 * t / TIME_S))[free]
    )
    resting, none = coast.at(TIME_S)
    assert resting == pytest.approx(coast.end)
    assert not none.any()


def test_a_joint_at_its_limit_goes_no_farther() -> None:
    """Encoders show angles a little beyond one."""
    robot = nao()
    coast = DecelerationProfile.within_limits(
        robot, robot.upper + 0.01, np.ones(len(robot.upper)), TIME_S
    )
    assert coast.at(0.0)[0] == pytest.approx(robot.upper, abs=1e-8)
    assert coast.end == pytest.approx(robot.upper, abs=1e-8)
    back = DecelerationProfile.within_limits(
        robot, robot.upper + 0.01, np.full(len(robot.upper), -1.0), TIME_S
    )
    assert (back.end < robot.upper).all()
