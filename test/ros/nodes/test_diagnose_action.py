"""Action `shoe/diagnose` over DDS: what is refused, and what ends it."""

from __future__ import annotations

from pathlib import Path

import pytest
from shoecal_msgs.action import Calibrate, Diagnose
from shoecal_msgs.srv import Rezero, SelfCalibrate

from ros.bodies import ODD, ODD_SHOE
from ros.standing_robot import StandingRobot
from ros.waiting_supports import WaitingSupports
from ros.world import Goal, World
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe

CODES = Diagnose.Result
SUPPORT = DoubleSupport(0.0, -0.112, 0.0)


def start(world: World, **parameters: object) -> None:
    world.start(
        "calibrator",
        {
            "stale_s": 10.0,
            "state_dir": world.folder / "state",
            "sessions_dir": world.folder / "sessions",
            **parameters,
        },
    )


def diagnose(world: World, **goal: object) -> Goal:
    return world.goal(Diagnose, "shoe/diagnose", Diagnose.Goal(**{"seed": -1, **goal}))


@pytest.fixture
def robot(world: World) -> StandingRobot:
    return StandingRobot(world, SUPPORT)


def test_codes_are_those_of_calibrate() -> None:
    for name in (
        "OK", "BUSY", "NOT_ARMED", "CANCELED", "SUPPORT_FAILED", "MOTION_FAILED",
        "RECORDING_FAILED", "STALE_INPUT", "BAD_GOAL", "FAILED",
    ):  # fmt: skip
        assert getattr(CODES, name) == getattr(Calibrate.Result, name), name


def test_recording_needs_arming_and_inputs(world: World, robot: StandingRobot) -> None:
    start(world)
    world.until_reported("calibrator", "voltages", "come")
    refused = diagnose(world).result()
    assert (refused.success, refused.error_code) == (False, CODES.NOT_ARMED)
    assert "shoe/arm" in refused.message
    assert (refused.verdict, refused.json, refused.session) == ("", "", "")
    world.arm("calibrator")
    robot.publishes_voltages = False
    world.until_reported("calibrator", "voltages", "no voltages for")
    stale = diagnose(world, motions=["landmarks"]).result()
    assert stale.error_code == CODES.STALE_INPUT
    assert "shoe_driver" in stale.message
    world.until_reported("calibrator", "diagnosis", "ended: no voltages")


def empty_session(folder: Path, robot: Path, shoe: Path) -> Path:
    body = load_robot(robot, load_shoe(shoe))
    return Session.create(folder, body.path, body.urdf, shoe).folder


def test_bad_goals_are_refused_before_anything_is_done(world: World) -> None:
    start(world)
    odd = empty_session(world.folder / "sessions" / "odd", ODD, ODD_SHOE)
    (world.folder / "sessions" / "empty").mkdir()
    for goal, reported in (
        ({"motions": ["landmarks", "somersault"]}, "somersault"),
        ({"session": "nowhere"}, f"{world.folder}/sessions/nowhere: does not exist"),
        ({"session": "empty"}, "is no session"),
        ({"session": str(odd)}, "named by its folder's name"),
        ({"session": ".."}, "without any path"),
        ({"session": "s\n1"}, "without any path"),
        ({"motions": ["hold"] * 101}, "record at most 100"),
        ({"session": odd.name, "motions": ["landmarks"]}, "nothing can be added to the session"),
        ({"session": odd.name, "run_proposed": True}, "nothing can be added to the session"),
    ):
        result = diagnose(world, **goal).result()
        assert result.error_code == CODES.BAD_GOAL, result.message
        assert reported in result.message


def test_one_job_at_a_time_and_cancelling_wins(world: World, robot: StandingRobot) -> None:
    supports = WaitingSupports(world)
    start(world)
    world.arm("calibrator")
    world.until_reported("calibrator", "voltages", "come")
    goal = diagnose(world, motions=["landmarks"])
    world.until(lambda: goal.feedback)
    assert goal.feedback[0].phase == "drawing"
    second = diagnose(world).result()
    assert second.error_code == CODES.BUSY
    assert "a diagnosis is under way" in second.message
    other = world.goal(Calibrate, "shoe/calibrate", Calibrate.Goal(seed=-1)).result()
    assert other.error_code == Calibrate.Result.BUSY
    request = SelfCalibrate.Request(seed=-1)
    assert not world.call(SelfCalibrate, "shoe/self_calibrate", request).accepted
    assert not world.call(Rezero, "shoe/rezero", Rezero.Request()).success
    world.until_reported("calibrator", "diagnosis", "under way")
    goal.cancel()
    result = goal.result()
    assert result.error_code == CODES.CANCELED
    assert not result.verdict
    supports.end()
    # The next one may begin, and ends where nobody brings the robot into supports.
    after = diagnose(world, motions=["landmarks"]).result()
    assert after.error_code == CODES.SUPPORT_FAILED
    assert "robot/reach_support" in after.message
    assert (Path(after.session) / "session.yaml").is_file()
