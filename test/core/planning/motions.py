"""Motions that several tests look at, planned once a test run."""

from __future__ import annotations

from functools import cache

from core.planning.bodies import load_body
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.steps import Stepper
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.double_support import DoubleSupport

SETTINGS = PlannerSettings()
SUPPORTS = (
    DoubleSupport(0.03, -0.125, 0.104),
    DoubleSupport(-0.02, -0.13, -0.26),
    DoubleSupport(0.06, -0.132, 0.2),
)


@cache
def planner_of(name: str) -> Planner:
    return Planner(load_body(name).robot, SETTINGS)


@cache
def step_of(name: str, support_phase: SupportPhase) -> Motion:
    """From the first double support to the second, on the foot asked for."""
    planner = planner_of(name)
    stepper = Stepper(planner)
    stepper.support_phase = support_phase.other
    motion = stepper.step(planner.stance(SUPPORTS[0]), SUPPORTS[1])
    assert motion is not None
    assert stepper.support_phase is support_phase
    return motion


@cache
def motion_of(name: str, index: int = 0) -> Motion:
    return planner_of(name).plan(SUPPORTS[index])
