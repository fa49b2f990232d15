"""Planned motions for the tests of their pictures, planned once a test run."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from core.planning.bodies import NAMES
from core.planning.motions import SETTINGS, SUPPORTS, planner_of
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.report.plan.content import PlannedMotion

SECOND = next(name for name in NAMES if name != "nao")
"""Another robot: twelve leg joints, none of which share a motor."""


@cache
def planned(name: str, motion: str = "landmarks", support: int = 0) -> PlannedMotion:
    """A motion of one of the robots, checked."""
    planner = planner_of(name)
    found = planner.plan(SUPPORTS[support], motion)
    report = check_motion(planner.legs, found, SETTINGS)
    return PlannedMotion("motion_001", planner.legs.robot, found, report, SETTINGS)


def reaching() -> PlannedMotion:
    """The NAO; all landmarks are reached."""
    return planned("nao", support=2)


def missing() -> PlannedMotion:
    """The second robot where the CoP shall come so near that one landmark is out of reach."""
    near = replace(SETTINGS, landmark_radius=0.0028)
    return replace(planned(SECOND, support=0), settings=near)


def stepping() -> PlannedMotion:
    """The second robot lifts its left foot for a moment."""
    return planned(SECOND, "unload_left")
