"""The command that brings a robot to rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.bodies import nao
from shoecal_core.robot.robot import Robot
from shoecal_ros.common.hold import HOLD_WAY, LONGEST_S, STOP_TIME_S, hold


def slow(share: float) -> Robot:
    """A NAO whose joints have so much of their speed."""
    model = nao().model.copy()
    model.velocityLimit = share * model.velocityLimit
    return replace(nao(), model=model)


@given(st.floats(0.02, 1.0), st.floats(0.05, 2.0), st.floats(-1.0, 1.0))
def test_no_joint_needs_to_be_faster_than_it_can(share: float, time_s: float, way: float) -> None:
    robot = slow(share)
    start = np.clip(robot.posture + way * HOLD_WAY, robot.lower, robot.upper)
    command = hold(robot, robot.posture, time_s)
    assert command.duration >= time_s
    whole = command.full(robot, start)
    rates = whole.rates(np.linspace(0.0, whole.duration, 101))
    assert (abs(rates) <= robot.velocity_limit + 1e-9).all()


def test_robots_that_are_fast_enough_stop_in_time() -> None:
    assert hold(nao(), nao().posture, STOP_TIME_S).duration == STOP_TIME_S
    # 1.5 of 0.2 rad at 4.16174 rad/s, hips and ankles' rolls.
    assert hold(nao(), nao().posture, 0.05).duration == pytest.approx(0.3 / 4.16174)


def test_a_robot_whose_speeds_are_not_known_is_stopped() -> None:
    assert hold(slow(0.0), nao().posture, STOP_TIME_S).duration == STOP_TIME_S


def test_no_stop_takes_for_ever() -> None:
    assert hold(slow(1e-9), nao().posture, STOP_TIME_S).duration == LONGEST_S
