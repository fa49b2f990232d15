"""A fault of the calibrator itself: who asked is answered, and the next one is served."""

from __future__ import annotations

from pathlib import Path

import pytest
from shoecal_msgs.action import Calibrate, Diagnose
from shoecal_msgs.srv import Rezero, SelfCalibrate, SetCalibration

from ros.bodies import calibration, nao, nao_shoe
from ros.standing_robot import StandingRobot
from ros.world import World
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.common.conversions import calibration_to_ros

FAULTY = Path(__file__).with_name("faulty_calibrator.py")
TOLD = "ended by a fault: ZeroDivisionError: made up, of two lines; see the node's log"


def started(world: World, script: Path) -> World:
    """A calibrator node that is ready for a job."""
    StandingRobot(world, DoubleSupport(0.0, -0.112, 0.0))
    folders = {name: world.folder / name for name in ("state_dir", "sessions_dir")}
    world.start("calibrator", {**folders, "stale_s": 10.0}, script=script)
    world.arm("calibrator")
    world.until_reported("calibrator", "voltages", "come")
    world.until_reported("calibrator", "joints", "come")
    return world


@pytest.fixture
def faulty(world: World) -> World:
    """Where the node's next job of each kind fails."""
    return started(world, FAULTY)


def test_actions_are_answered(faulty: World) -> None:
    calibrate = Calibrate.Goal(supports=2, train=2, seed=1)
    for kind, name, goal in (
        (Calibrate, "shoe/calibrate", calibrate),
        (Diagnose, "shoe/diagnose", Diagnose.Goal(seed=-1)),
    ):
        result = faulty.goal(kind, name, goal).result()
        assert (result.success, result.error_code) == (False, kind.Result.FAILED)
        assert TOLD in result.message
        assert result.run_id
    faulty.until_reported("calibrator", "diagnosis", f"ended: {TOLD}")
    faulty.until_logged("calibrator", "Traceback")
    # The next job begins.
    after = faulty.goal(Calibrate, "shoe/calibrate", calibrate)
    faulty.until(lambda: after.feedback)
    after.cancel()
    assert after.result().error_code == Calibrate.Result.CANCELED


def test_a_job_that_a_service_began_tells_it(faulty: World) -> None:
    request = SelfCalibrate.Request(supports=2, train=2, seed=1)
    assert faulty.call(SelfCalibrate, "shoe/self_calibrate", request).accepted
    faulty.until_reported("calibrator", "calibration", TOLD)


def test_a_job_that_fails_as_it_begins_does_not_block_the_next_one(world: World) -> None:
    started(world, FAULTY.with_name("calibrator_that_cannot_begin.py"))
    request = SelfCalibrate.Request(supports=2, train=2, seed=1)
    answer = world.call(SelfCalibrate, "shoe/self_calibrate", request)
    assert not answer.accepted
    assert TOLD in answer.message
    assert world.call(SelfCalibrate, "shoe/self_calibrate", request).accepted


def test_services_are_answered(faulty: World) -> None:
    made = calibration_to_ros(calibration(nao(), nao_shoe(), "one"))
    request = SetCalibration.Request(calibration=made)
    failed = faulty.call(SetCalibration, "shoe/set_calibration", request)
    assert (failed.success, failed.error_code) == (False, SetCalibration.Response.FAILED)
    assert TOLD in failed.message
    assert faulty.call(SetCalibration, "shoe/set_calibration", request).success
    failed = faulty.call(Rezero, "shoe/rezero", Rezero.Request())
    assert (failed.success, failed.error_code) == (False, Rezero.Response.FAILED)
    assert TOLD in failed.message
