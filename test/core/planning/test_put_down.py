"""A robot that was stopped on one foot puts the other one down, and does nothing else."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from core.planning.motions import SETTINGS, planner_of
from shoecal_core.arrays import FloatArray
from shoecal_core.planning.checking.body_track import track
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.motion_catalogue import PUT_DOWN
from shoecal_core.planning.planner import StartError
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.steps import Stepper
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.planning.swing import stance_foot, swing_height
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.settings import SettingError

HERE, THERE = DoubleSupport(0.0, -0.115, 0.0), DoubleSupport(0.04, -0.125, -0.2)


@cache
def lifting(motion: str) -> Motion:
    planner = planner_of("nao")
    if motion == "step":
        step = Stepper(planner).step(planner.stance(HERE), THERE)
        assert step is not None
        return step
    return planner.plan(HERE, motion)


def swing_segment(motion: Motion) -> tuple[FloatArray, FloatArray]:
    """(n, m) joint angles while one foot carries, and (n,) how high the other one is [m]."""
    spans = [phase for phase in motion.phases if phase.support_phase is not SupportPhase.BOTH]
    within = (motion.time >= spans[0].begin) & (motion.time <= spans[-1].end)
    angles = motion.positions[within]
    return angles, np.abs(track(planner_of("nao").legs.robot, angles).right_translation[:, 2])


@pytest.mark.parametrize("name", ["step", "unload_left", "unload_right"])
def test_only_the_foot_in_the_air_moves_first(name: str) -> None:
    """Wherever a motion is stopped, it is either put down or stands already."""
    planner = planner_of("nao")
    angles, heights = swing_segment(lifting(name))
    assert heights.max() > 2.0 * SETTINGS.sole_height
    for index in range(0, len(angles), 7):
        if heights[index] <= SETTINGS.sole_height:
            with pytest.raises(StartError, match="both feet stand"):
                planner.standing_on_one(angles[index])
            continue
        with pytest.raises(StartError, match=r"mm above the other .*'put_down'"):
            planner.standing(angles[index])
        with pytest.raises(StartError):
            Stepper(planner).step(angles[index], THERE)


@pytest.mark.parametrize("name", ["step", "unload_left", "unload_right"])
def test_the_foot_comes_down_where_it_is(name: str) -> None:
    planner = planner_of("nao")
    robot = planner.legs.robot
    angles, heights = swing_segment(lifting(name))
    for start in (int(np.argmax(heights)), int(np.argmax(heights > 1.2 * SETTINGS.sole_height))):
        motion = planner.plan_from(angles[start], PUT_DOWN)
        assert check_motion(planner.legs, motion, SETTINGS).kept
        assert [phase.name for phase in motion.phases] == ["lower", "back"]
        support_phase = [phase.support_phase for phase in lifting(name).phases]
        one = next(foot for foot in support_phase if foot is not SupportPhase.BOTH)
        assert [phase.support_phase for phase in motion.phases] == [one, SupportPhase.BOTH]
        body = track(robot, motion.positions)
        np.testing.assert_allclose(motion.positions[0], angles[start], atol=1e-12)
        np.testing.assert_allclose(body.right_translation[-1, 2], 0.0, atol=SETTINGS.foot_drift)
        standing = planner.standing(motion.positions[-1])
        assert standing.support_phase is SupportPhase.BOTH
        if one is SupportPhase.LEFT:
            moved = body.right_translation[:, :2] - body.right_translation[0, :2]
            assert np.abs(moved).max() < 2e-4


def test_feet_that_stand_are_not_put_down() -> None:
    planner = planner_of("nao")
    with pytest.raises(StartError, match="both feet stand"):
        planner.plan(HERE, PUT_DOWN)


def test_a_foot_in_the_air_is_never_taken_for_one_that_stands() -> None:
    with pytest.raises(SettingError, match="sole_height"):
        PlannerSettings(sole_height=0.008)
    with pytest.raises(SettingError, match="half of lift"):
        PlannerSettings(lift=0.008)


@pytest.mark.parametrize(("name", "joint"), [("unload_left", "LAnkleRoll"), ("step", "RAnkleRoll")])
def test_a_foot_that_hangs_tilted_comes_down_flat(name: str, joint: str) -> None:
    """Gears give: the sole in the air is not level to the one that stands."""
    planner = planner_of("nao")
    robot = planner.legs.robot
    angles, heights = swing_segment(lifting(name))
    start = angles[int(np.argmax(heights))].copy()
    start[robot.joint(joint)] += 0.03
    body = track(robot, planner.plan_from(start, PUT_DOWN).positions)
    np.testing.assert_allclose(body.right_translation[-1, 2], 0.0, atol=SETTINGS.foot_drift)


def test_tilted_soles_are_judged_by_the_higher_look() -> None:
    """From the left sole the right one looks 4 mm up; from the right one the left one 6 mm."""
    tilt = Rotation.from_euler("x", 0.1).as_matrix()
    pose = FootPose(tilt, np.array([0.0, -0.1, 0.004]))
    looks = [swing_height(pose, foot) for foot in (SupportPhase.LEFT, SupportPhase.RIGHT)]
    foot, height = stance_foot(pose)
    assert height == max(looks)
    assert foot is (SupportPhase.LEFT, SupportPhase.RIGHT)[int(np.argmax(looks))]
    level = FootPose(np.eye(3), np.array([0.0, -0.1, 0.012]))
    for pose, foot in ((level, SupportPhase.LEFT), (level.inverse, SupportPhase.RIGHT)):
        found, height = stance_foot(pose)
        assert found is foot
        assert height == pytest.approx(0.012)
