from __future__ import annotations

import socket
from collections.abc import Callable
from itertools import cycle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import PointStamped, Vector3Stamped, WrenchStamped
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter
from sensor_msgs.msg import JointState
from shoecal_msgs.action import Calibrate
from shoecal_msgs.msg import ShoeCalibration, ShoeForces, ShoeState, ShoeVoltages
from shoecal_msgs.srv import Apply, GetCalibration, Rezero, SelfCalibrate, SetCalibration
from std_srvs.srv import Trigger

from ros.bodies import ROOT, calibration, nao, nao_shoe
from ros.obliging_robot import ObligingRobot
from ros.standing_robot import StandingRobot
from ros.waiting_supports import WaitingSupports
from ros.world import Goal, Received, World
from shoecal_core.estimation.calibration import load_calibration, save_calibration
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.screening.verdict import list_reasons
from shoecal_core.shoe.shoe import FEET
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code
from shoecal_ros.common.conversions import (
    calibration_from_ros,
    calibration_to_ros,
    point_from_ros,
    time_from_ros,
)
from shoecal_ros.common.health import Level

EXAMPLE = ROOT / "shoecal_ros/shoecal_ros/examples/controller.py"
SUPPORT = DoubleSupport(0.0, -0.112, 0.0)
PATIENT = {"stale_s": 10.0}
LIVE = {
    "shoe/cop": PointStamped,
    "shoe/left/cop": PointStamped,
    "shoe/right/cop": PointStamped,
    "shoe/grf": WrenchStamped,
    "shoe/left/grf": WrenchStamped,
    "shoe/right/grf": WrenchStamped,
}


def start(world: World, **parameters: object) -> None:
    world.start(
        "calibrator",
        {
            **PATIENT,
            "state_dir": world.folder / "state",
            "sessions_dir": world.folder / "sessions",
            **parameters,
        },
    )


def hear_all(world: World) -> dict[str, Received]:
    return {topic: world.receive(kind, topic, qos.LIVE) for topic, kind in LIVE.items()}


def set_calibration(world: World, *, force: bool = False, **changes: object) -> Any:
    message = calibration_to_ros(calibration(nao(), nao_shoe(), **changes))  # type: ignore[arg-type]
    request = SetCalibration.Request(calibration=message, force=force)
    return world.call(SetCalibration, "shoe/set_calibration", request)


def in_force(world: World) -> str:
    found = world.call(GetCalibration, "shoe/get_calibration", GetCalibration.Request())
    return str(found.calibration.id) if found.calibrated else ""


def fresh(world: World, heard: Received, count: int = 2 * qos.LIVE.depth) -> Any:
    """A message that was sampled after now: what is under way comes first."""
    seen = len(heard)
    world.until(lambda: len(heard) >= seen + count)
    return heard.last


def state(world: World, condition: Callable[[Any], bool]) -> Any:
    heard = world.receive(ShoeState, "shoe/state", qos.LATCHED)
    world.until(lambda: len(heard) and condition(heard.last))
    return heard.last


@pytest.fixture
def robot(world: World) -> StandingRobot:
    return StandingRobot(world, SUPPORT)


@pytest.fixture
def live(world: World, robot: StandingRobot) -> World:
    """A calibrated calibrator beside a robot that stands on both feet."""
    start(world)
    assert set_calibration(world).success
    return world


def test_forces_and_places_are_live(live: World, robot: StandingRobot) -> None:
    heard = hear_all(live)
    live.until(lambda: all(len(one) > 3 for one in heard.values()))
    for foot, name in enumerate(("left", "right")):
        cop, grf = (heard[f"shoe/{name}/{kind}"].last for kind in ("cop", "grf"))
        assert cop.header.frame_id == grf.header.frame_id == f"{name[0]}_sole"
        np.testing.assert_allclose(point_from_ros(cop)[:2], robot.places[foot], atol=1e-9)
        assert grf.wrench.force.z == pytest.approx(robot.forces[foot])
    right = Kinematics(nao()).states(robot.angles[None]).support().right_to_left(robot.places[1])
    shares = np.array(robot.forces) / sum(robot.forces)
    expected = shares[0] * robot.places[0] + shares[1] * right
    cop, grf = fresh(live, heard["shoe/cop"]), heard["shoe/grf"].last
    assert cop.header.frame_id == grf.header.frame_id == "l_sole"
    np.testing.assert_allclose(point_from_ros(cop)[:2], expected, atol=1e-8)
    force, about_x, about_y = grf.wrench.force.z, grf.wrench.torque.x, grf.wrench.torque.y
    assert force == pytest.approx(sum(robot.forces))
    np.testing.assert_allclose([-about_y / force, about_x / force], expected, atol=1e-8)
    reported = state(live, lambda one: one.state == ShoeState.CALIBRATED and one.feet[0].valid)
    assert reported.calibration_id == "made-1"
    assert [foot.loaded for foot in reported.feet] == [True, True]
    assert tuple(reported.feet[1].cell) == nao_shoe().names[4:]


def test_a_whole_sample_comes_in_one_message(live: World, robot: StandingRobot) -> None:
    forces = live.receive(ShoeForces, "shoe/forces", qos.LIVE)
    # Once a second of standing has confirmed the calibration.
    live.until(lambda: len(forces) and forces.last.both.valid)
    found = fresh(live, forces)
    assert (found.calibration, found.header.frame_id) == ("made-1", "l_sole")
    for foot, one in enumerate((found.left, found.right)):
        assert one.valid
        assert one.wrench.force.z == pytest.approx(robot.forces[foot])
        np.testing.assert_allclose([one.cop.x, one.cop.y], robot.places[foot], atol=1e-9)
    assert found.both.valid
    robot.publishes_right = False
    robot.apart = True
    live.until(lambda: forces.last.right.stale)
    assert not forces.last.right.valid
    assert not forces.last.both.valid


def test_the_sum_may_have_a_frame_that_stays(world: World, robot: StandingRobot) -> None:
    start(world, sum_frame="left", frame_prefix="one/")
    assert set_calibration(world).success
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    robot.forces = (0.5, nao().weight - 0.5)
    right = Kinematics(nao()).states(robot.angles[None]).support().right_to_left(robot.places[1])

    def on_right_alone() -> bool:
        """Joint angles that a busy machine brings late leave the sum out or mixed for a moment."""
        if not len(forces) or forces.last.left.loaded:
            return False
        cop = forces.last.both.cop
        return bool(np.allclose([cop.x, cop.y], right, rtol=0.0, atol=1e-3))

    world.until(on_right_alone, waited_for="the sum on the right foot alone")
    assert forces.last.both.frame_id == "one/l_sole"


def test_the_example_controller_uses_what_it_may(live: World, robot: StandingRobot) -> None:
    # Its clock is the computer's, and so are the stamps.
    robot.stamped_now = True
    error = live.receive(Vector3Stamped, "example/cop_error", qos.LIVE)
    live.start("example_controller", {"target_x": 0.01}, script=EXAMPLE)
    cop = live.receive(PointStamped, "shoe/cop", qos.LIVE)

    def pairs() -> list[tuple[Vector3Stamped, PointStamped]]:
        stamps = {time_from_ros(one.header.stamp): one for one in cop.messages}
        stamped = [(one, stamps.get(time_from_ros(one.header.stamp))) for one in error.messages]
        return [(one, measured) for one, measured in stamped if measured is not None]

    live.until(lambda: len(pairs()) > 3)
    for computed, measured in pairs():
        assert computed.vector.x == pytest.approx(measured.point.x - 0.01, abs=1e-6)
    robot.status = {nao_shoe().names[0]: ShoeVoltages.SATURATED}
    forces = live.receive(ShoeForces, "shoe/forces", qos.LIVE)
    live.until(lambda: len(forces) and not forces.last.both.valid)
    invalid_from = time_from_ros(forces.last.header.stamp)
    fresh(live, forces)
    assert all(time_from_ros(one.header.stamp) < invalid_from for one in error.messages)


def test_on_the_right_foot_the_frame_changes_and_the_left_one_is_silent(
    live: World, robot: StandingRobot
) -> None:
    heard = hear_all(live)
    live.until(lambda: len(heard["shoe/cop"]))
    robot.forces = (0.5, nao().weight - 0.5)
    live.until(lambda: heard["shoe/cop"].last.header.frame_id == "r_sole")
    fresh(live, heard["shoe/cop"])
    silent = len(heard["shoe/left/cop"])
    cop = fresh(live, heard["shoe/cop"])
    np.testing.assert_allclose(point_from_ros(cop)[:2], robot.places[1], atol=1e-9)
    assert len(heard["shoe/left/cop"]) == silent
    assert fresh(live, heard["shoe/left/grf"]).wrench.force.z == pytest.approx(0.5)
    assert [foot.loaded for foot in state(live, lambda one: not one.feet[0].loaded).feet] == [
        False, True,
    ]  # fmt: skip
    robot.forces = (5.0, nao().weight - 5.0)  # between the limits: still on the right one
    assert fresh(live, heard["shoe/cop"]).header.frame_id == "r_sole"
    robot.forces = (20.0, nao().weight - 20.0)
    live.until(lambda: heard["shoe/cop"].last.header.frame_id == "l_sole")


def test_a_broken_cell_silences_what_it_spoils(live: World, robot: StandingRobot) -> None:
    heard = hear_all(live)
    live.until(lambda: len(heard["shoe/cop"]))
    state(live, lambda one: one.feet[0].valid)
    robot.status = {"left/rear_left": ShoeVoltages.NO_DATA}
    reported = state(live, lambda one: not one.feet[0].valid)
    assert list(reported.feet[0].status) == [0, 0, ShoeVoltages.NO_DATA, 0]
    assert reported.feet[1].valid
    fresh(live, heard["shoe/right/cop"])
    silent = {topic: len(one) for topic, one in heard.items()}
    fresh(live, heard["shoe/right/cop"])
    for topic in ("shoe/cop", "shoe/grf", "shoe/left/cop", "shoe/left/grf"):
        assert len(heard[topic]) == silent[topic], topic
    for one in heard["shoe/cop"].messages:
        assert np.isfinite(point_from_ros(one)).all()


def test_stale_joints_silence_the_sum_and_stale_voltages_everything(world: World) -> None:
    robot = StandingRobot(world, SUPPORT)
    start(world, stale_s=0.5)
    assert set_calibration(world).success
    heard = hear_all(world)
    world.until(lambda: len(heard["shoe/cop"]))
    state(world, lambda one: one.feet[0].valid and not one.joints_stale)
    robot.publishes_joints = False
    state(world, lambda one: one.joints_stale and one.feet[0].valid)
    world.until_reported("calibrator", "joints", "no joint angles for")
    fresh(world, heard["shoe/left/cop"])
    silent = len(heard["shoe/cop"])
    fresh(world, heard["shoe/left/cop"])
    assert len(heard["shoe/cop"]) == silent
    robot.publishes_voltages = False
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    reported = state(world, lambda one: all(foot.stale for foot in one.feet))
    assert not any(foot.valid for foot in reported.feet)
    world.until(lambda: len(forces) and forces.last.both.stale and forces.last.left.stale)
    last = forces.last
    assert not any(one.valid for one in (last.left, last.right, last.both))
    assert np.isnan(forces.last.left.wrench.force.z)
    robot.publishes_joints = robot.publishes_voltages = True
    state(world, lambda one: not one.joints_stale and one.feet[0].valid)
    fresh(world, heard["shoe/cop"])


@pytest.mark.parametrize("away", [0, 1])
def test_a_foot_whose_board_is_silent_is_stale_beside_the_other(world: World, away: int) -> None:
    robot = StandingRobot(world, SUPPORT)
    robot.apart = True
    start(world)
    assert set_calibration(world).success
    heard = hear_all(world)
    state(world, lambda one: all(foot.valid for foot in one.feet))
    fresh(world, heard["shoe/cop"])
    gone, there = FEET[away], FEET[1 - away]
    setattr(robot, f"publishes_{gone}", False)
    reported = state(world, lambda one: one.feet[away].stale and not one.feet[1 - away].stale)
    assert (reported.feet[1 - away].valid, reported.feet[away].valid) == (True, False)
    fresh(world, heard[f"shoe/{there}/cop"])
    silent = {topic: len(heard[topic]) for topic in ("shoe/cop", "shoe/grf", f"shoe/{gone}/grf")}
    fresh(world, heard[f"shoe/{there}/cop"])
    assert silent == {topic: len(heard[topic]) for topic in silent}
    setattr(robot, f"publishes_{gone}", True)
    state(world, lambda one: all(foot.valid for foot in one.feet))
    fresh(world, heard["shoe/cop"])


def test_uncalibrated_nothing_is_published(world: World, robot: StandingRobot) -> None:
    start(world)
    heard = hear_all(world)
    world.until_discovered_by("calibrator")
    world.until_reported("calibrator", "calibration", "uncalibrated")
    reported = state(world, lambda one: not one.feet[0].stale)
    assert reported.state == ShoeState.UNCALIBRATED
    assert not any(len(one) for one in heard.values())
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    world.until(lambda: len(forces) and not forces.last.left.stale)
    assert forces.last.calibration == ""
    assert not forces.last.left.valid
    assert in_force(world) == ""


def test_two_sources_of_one_cell_are_a_fault(live: World, robot: StandingRobot) -> None:
    rival = live.node.create_publisher(ShoeVoltages, "shoe/voltages", qos.RAW)
    other = ShoeVoltages(cell=["left/rear_left"], voltage=[1.0], status=[0])
    other.header.frame_id = "rival"

    def reported() -> bool:
        other.header.stamp.sec += 1
        rival.publish(other)
        status = live.diagnosis("calibrator", "voltages")
        return status is not None and "'rival'" in status.message

    live.until(reported)
    assert "left/rear_left" in live.diagnosis("calibrator", "voltages").message


def test_the_calibration_is_latched_mirrored_and_read_only(live: World) -> None:
    latched = live.receive(ShoeCalibration, "shoe/calibration", qos.LATCHED)
    live.until(lambda: len(latched))
    assert latched.last.id == "made-1"
    request = GetParameters.Request(names=["in_force.id", "in_force.gains"])
    found = live.call(GetParameters, "calibrator/get_parameters", request)
    assert found.values[0].string_value == "made-1"
    np.testing.assert_array_equal(found.values[1].double_array_value, latched.last.gain)
    change = Parameter("in_force.id", value="mine").to_parameter_msg()
    answer = live.call(
        SetParameters, "calibrator/set_parameters", SetParameters.Request(parameters=[change])
    )
    assert not answer.results[0].successful
    assert "shoe/set_calibration" in answer.results[0].reason
    assert set_calibration(live, identity="made-2").success
    found = live.call(GetParameters, "calibrator/get_parameters", request)
    assert found.values[0].string_value == "made-2"


def test_set_refuse_roll_back_and_restart(live: World) -> None:
    assert set_calibration(live, identity="made-2").success
    refused = set_calibration(live, identity="made-3", verdict="FAIL", reasons=("blind",))
    assert not refused.success
    assert "blind" in refused.message
    for changes in ({"verdict": "WARN", "reasons": ("odd",)}, {"shoe_hash": "0" * 64}):
        assert not set_calibration(live, identity="made-4", **changes).success
    assert in_force(live) == "made-2"
    assert live.call(Trigger, "shoe/rollback", Trigger.Request()).success
    assert in_force(live) == "made-1"
    assert live.stop("calibrator") == 0
    start(live)
    assert in_force(live) == "made-1"
    assert live.call(Trigger, "shoe/rollback", Trigger.Request()).success
    assert in_force(live) == "made-2"
    warned = set_calibration(live, identity="made-5", verdict="WARN", reasons=("odd",), force=True)
    assert warned.success


def test_a_damaged_state_is_told(world: World, robot: StandingRobot) -> None:
    folder = world.folder / "state"
    folder.mkdir()
    (folder / "calibration.yaml").write_text("format: 99\n")
    start(world)
    status = world.until_reported("calibrator", "calibration", "calibration.yaml")
    assert "update shoecal" in status.message


def rezero(world: World) -> Rezero.Response:
    """Once the calibrator hears the robot."""
    for subject in ("joints", "voltages"):
        world.until_reported("calibrator", subject, "come")
    return world.call(Rezero, "shoe/rezero", Rezero.Request())


def test_offsets_are_corrected_at_a_standstill(live: World, robot: StandingRobot) -> None:
    robot.stand_as_modelled()
    robot.drift[:] = np.linspace(-0.5, 0.8, len(robot.drift))
    cop = live.receive(PointStamped, "shoe/cop", qos.LIVE)
    grf = live.receive(WrenchStamped, "shoe/grf", qos.LIVE)
    answer = rezero(live)
    assert answer.success, answer.message
    assert tuple(answer.channel) == nao_shoe().names
    assert sum(answer.change) == pytest.approx(-robot.drift.sum(), abs=1e-6)
    modelled = Kinematics(nao()).states(robot.angles[None]).cop[0, 0]
    np.testing.assert_allclose(point_from_ros(fresh(live, cop))[:2], modelled, atol=1e-6)
    assert fresh(live, grf).wrench.force.z == pytest.approx(nao().weight, abs=1e-6)
    assert in_force(live).startswith("rezero-")
    robot.drift += 20.0
    refused = rezero(live)
    assert not refused.success
    assert refused.error_code == Rezero.Response.TOO_FAR
    assert "calibrate again" in refused.message


def test_offsets_are_not_corrected_while_the_robot_moves(world: World) -> None:
    robot = StandingRobot(world, SUPPORT)
    start(world, rezero_time=0.3)
    assert set_calibration(world).success
    robot.speed = 0.05
    refused = rezero(world)
    assert not refused.success
    assert refused.error_code == Rezero.Response.NOT_STILL
    assert "stand still" in refused.message


def calibrate(world: World, **goal: float) -> Goal:
    return world.goal(Calibrate, "shoe/calibrate", Calibrate.Goal(**{"seed": -1, **goal}))


def test_a_job_needs_arming_inputs_and_sense(world: World, robot: StandingRobot) -> None:
    start(world)
    codes = Calibrate.Result
    world.until_reported("calibrator", "voltages", "come")
    refused = calibrate(world).result()
    assert refused.error_code == codes.NOT_ARMED
    assert "shoe/arm" in refused.message
    world.arm("calibrator")
    bad = calibrate(world, supports=3, train=4).result()
    assert bad.error_code == codes.BAD_GOAL
    for target in (-0.001, np.nan, np.inf):
        bad = calibrate(world, target=target).result()
        assert bad.error_code == codes.BAD_GOAL
        assert "in metres" in bad.message
    robot.publishes_voltages = False
    world.until_reported("calibrator", "voltages", "no voltages for")
    stale = calibrate(world).result()
    assert stale.error_code == codes.STALE_INPUT
    assert "shoe_driver" in stale.message


def test_one_job_at_a_time_and_an_end_when_nobody_reaches_supports(
    world: World, robot: StandingRobot
) -> None:
    supports = WaitingSupports(world)
    start(world)
    world.arm("calibrator")
    world.until_reported("calibrator", "voltages", "come")
    goal = calibrate(world, supports=2, train=2)
    world.until(lambda: goal.feedback)
    assert goal.feedback[0].stage == "drawing"
    assert calibrate(world).result().error_code == Calibrate.Result.BUSY
    request = SelfCalibrate.Request(seed=-1)
    busy = world.call(SelfCalibrate, "shoe/self_calibrate", request)
    assert not busy.accepted
    assert busy.error_code == Calibrate.Result.BUSY
    run_id = goal.feedback[0].run_id
    assert state(world, lambda one: (one.state, one.run_id) == (ShoeState.CALIBRATING, run_id))
    world.until(lambda: goal.feedback[-1].stage == "reaching")
    supports.fail()
    result = goal.result()
    assert result.error_code == Calibrate.Result.SUPPORT_FAILED
    assert "not reached: nobody walks here" in result.message
    world.until_logged("calibrator", f"[{result.run_id}] drawing 0: ")
    world.until_logged("calibrator", f"[{result.run_id}] self-calibration ended: ")
    assert (Path(result.session) / "session.yaml").is_file()
    assert state(world, lambda one: (one.state, one.run_id) == (ShoeState.UNCALIBRATED, ""))
    supports.end()
    alone = calibrate(world, supports=2, train=2).result()
    assert alone.error_code == Calibrate.Result.SUPPORT_FAILED
    assert "no node offers the action robot/reach_support" in alone.message


def test_a_job_is_cancelled_at_once(world: World, robot: StandingRobot) -> None:
    WaitingSupports(world)
    start(world)
    world.arm("calibrator")
    world.until_reported("calibrator", "voltages", "come")
    goal = calibrate(world, supports=5, train=3)
    world.until(lambda: goal.feedback)
    goal.cancel()
    assert goal.result().error_code == Calibrate.Result.CANCELED
    answer = world.call(SelfCalibrate, "shoe/self_calibrate", SelfCalibrate.Request(seed=-1))
    assert answer.accepted
    assert answer.run_id
    robot.publishes_joints = False
    world.until_reported("calibrator", "calibration", "no joint angles")
    values = {pair.key: pair.value for pair in world.diagnosis("calibrator", "calibration").values}
    assert values["code"] == Code.SELF_CALIBRATION_ENDED
    assert values["error_code"] == str(Calibrate.Result.STALE_INPUT)


def test_it_answers_that_it_is_not_armed(world: World, robot: StandingRobot) -> None:
    start(world)
    world.until_reported("calibrator", "voltages", "come")
    world.until_reported("calibrator", "joints", "come")
    request = SelfCalibrate.Request(seed=-1)
    answer = world.call(SelfCalibrate, "shoe/self_calibrate", request)
    assert (answer.accepted, answer.run_id) == (False, "")
    assert answer.error_code == Calibrate.Result.NOT_ARMED
    assert "call the service shoe/arm" in answer.message
    world.arm("calibrator")
    robot.publishes_joints = False
    world.until_reported("calibrator", "joints", "no joint angles")
    answer = world.call(SelfCalibrate, "shoe/self_calibrate", request)
    assert answer.error_code == Calibrate.Result.STALE_INPUT
    assert state(world, lambda one: one.state == ShoeState.UNCALIBRATED)


def test_a_warning_can_be_accepted_afterwards(live: World) -> None:
    for run_id, verdict in (("run-1", "WARN"), ("run-2", "FAIL")):
        folder = live.folder / "sessions" / run_id
        folder.mkdir(parents=True)
        made = calibration(nao(), nao_shoe(), run_id, verdict=verdict, reasons=("odd",))
        save_calibration(made, folder / "calibration.yaml")
    for run_id, code in (
        ("run-2", Apply.Response.NOT_APPLICABLE),
        ("run-3", Apply.Response.NOT_FOUND),
        ("../sessions/run-1", Apply.Response.NOT_FOUND),
        ("", Apply.Response.NOT_FOUND),
    ):
        refused = live.call(Apply, "shoe/apply", Apply.Request(run_id=run_id))
        assert (refused.success, refused.error_code) == (False, code), refused.message
        assert in_force(live) == "made-1"
    accepted = live.call(Apply, "shoe/apply", Apply.Request(run_id="run-1"))
    assert accepted.success, accepted.message
    assert in_force(live) == "run-1"
    status = live.until_reported("calibrator", "calibration", "'run-1' in force (WARN): odd")
    assert status.level == bytes([Level.WARN])


def test_two_clocks_are_told(world: World, robot: StandingRobot) -> None:
    robot.ahead_ns = 5_000_000_000
    start(world)
    world.arm("calibrator")
    world.until_reported("calibrator", "voltages", "come")
    world.until_reported("calibrator", "joints", "come")
    result = calibrate(world).result()
    assert result.error_code == Calibrate.Result.STALE_INPUT
    assert "one clock" in result.message
    world.until_reported("calibrator", "joints", "one clock")
    robot.ahead_ns = 0
    world.until_reported("calibrator", "joints", "joints come")


def test_joints_of_another_robot_are_named(world: World) -> None:
    start(world)
    publisher = world.publisher(JointState, "joint_states")
    odd = JointState(name=["elbow"], position=[0.1])
    odd.header.stamp.sec = 5
    publisher.publish(odd)
    status = world.until_reported("calibrator", "joints", "needs joint(s)")
    assert "elbow" in status.message


# What is in force


def got(world: World) -> Any:
    return world.call(GetCalibration, "shoe/get_calibration", GetCalibration.Request())


def test_a_simulated_calibration_is_not_put_in_force_on_a_robot(live: World) -> None:
    refused = set_calibration(live, identity="demo", made_ns=10**11, force=True)
    assert refused.error_code == SetCalibration.Response.NOT_APPLICABLE
    assert "was made in simulated time" in refused.message
    assert in_force(live) == "made-1"


def test_reasons_of_a_refusal_come_back(live: World) -> None:
    for verdict, reported in (("WARN", "with force"), ("FAIL", "calibrate again")):
        refused = set_calibration(live, identity="made-2", verdict=verdict, reasons=("a", "b"))
        assert not refused.success
        assert refused.error_code == SetCalibration.Response.NOT_APPLICABLE
        assert "(a; b)" in refused.message
        assert reported in refused.message
    warned = set_calibration(live, identity="made-2", verdict="WARN", reasons=("a",), force=True)
    assert warned.success
    status = live.until_reported("calibrator", "calibration", "'made-2' in force (WARN): a")
    assert status.level == bytes([Level.WARN])
    values = {value.key: value.value for value in status.values}
    assert values["id"] == "made-2"
    assert values["verdict"] == "WARN"
    assert (values["robot"], values["shoe"]) == ("nao", "nao_shoe")


def test_since_when_survives_whatever_ends_the_node(live: World) -> None:
    assert set_calibration(live, identity="made-2", verdict="WARN", force=True).success
    since = got(live).since
    assert since.sec > 0
    assert live.stop("calibrator") == 0
    start(live)
    found = got(live)
    assert found.calibration.id == "made-2"
    assert found.since == since
    for part in ("'made-2' (self, WARN)", "robot 'nao'", "shoe 'nao_shoe'"):
        assert part in found.message
    assert live.call(Trigger, "shoe/rollback", Trigger.Request()).success
    back = got(live)
    assert back.calibration.id == "made-1"
    assert (back.since.sec, back.since.nanosec) > (since.sec, since.nanosec)
    killed = live.processes.pop("calibrator")
    killed.kill()
    killed.wait()
    start(live)
    latched = live.receive(ShoeCalibration, "shoe/calibration", qos.LATCHED)
    live.until(lambda: len(latched))
    assert latched.last.id == "made-1"


def test_another_temperature_asks_for_a_rezero(world: World, robot: StandingRobot) -> None:
    start(world, rezero_time=0.3)
    robot.stand_as_modelled()
    robot.temperature = 31.25
    assert set_calibration(world, temperature=22.0).success
    reported = world.until_reported("calibrator", "calibration", "calibrated at 22 degC, now 31")
    assert reported.level == bytes([Level.WARN])
    found = got(world)
    assert (found.calibration.temperature, found.temperature) == (22.0, 31.25)
    assert rezero(world).success
    world.until_reported("calibrator", "calibration", "' in force (PASS)")
    assert got(world).calibration.temperature == 31.25


# A manual calibration as prior


def test_a_prior_of_other_shoes_ends_the_node_with_one_line(world: World) -> None:
    file = world.folder / "manual.yaml"
    shoe = nao_shoe()
    names = (*shoe.names[:-1], "right/nose")
    save_calibration(calibration(nao(), shoe, channels=names), file)
    start(world, manual_file=file)
    assert world.ended("calibrator") == 1
    (line,) = world.output("calibrator").splitlines()
    assert f"{file}: calibration 'made-1' is of shoe 'nao_shoe'" in line
    assert "name another manual_file" in line


def test_a_prior_that_the_method_ignores_ends_the_node_with_one_line(world: World) -> None:
    file = world.folder / "manual.yaml"
    save_calibration(calibration(nao(), nao_shoe()), file)
    start(world, manual_file=file, **{"calibration.method": "paper"})
    assert world.ended("calibrator") == 1
    (line,) = world.output("calibrator").splitlines()
    assert "the manual calibration would be ignored" in line
    assert "manual_file" in line


# Drift


def test_drift_is_told_and_cured(world: World, robot: StandingRobot) -> None:
    start(world, drift_time=0.5, rezero_time=0.5)
    robot.stand_as_modelled()
    world.until_reported("calibrator", "drift", "no calibration")
    covariance = 1e-4 * np.eye(2 * len(robot.drift))
    assert set_calibration(world, covariance=covariance, fitted_runs=("ab",)).success
    reported = world.until_reported("calibrator", "drift", "as calibrated: GRF is")
    assert reported.level == bytes([Level.OK])
    robot.drift[2] = 1.0
    reported = world.until_reported("calibrator", "drift", "drifted: GRF is +1.00 N off the weight")
    assert reported.level == bytes([Level.WARN])
    assert "call shoe/rezero" in reported.message
    assert {value.key for value in reported.values} >= {
        "grf_error_n",
        "grf_limit_n",
        "cop_error_mm",
    }
    answer = rezero(world)
    assert answer.success, answer.message
    assert (answer.directions, answer.channels) == (3, 8)
    assert answer.grf_before == pytest.approx(1.0, abs=1e-6)
    assert answer.grf_after == pytest.approx(0.0, abs=1e-6)
    assert answer.cop_after < 1e-6 < answer.cop_before
    assert 0.0 < answer.grf_left < 1.0
    assert 0.0 < answer.cop_left < 0.02
    assert "corrected GRF by 1.00 N" in answer.message
    assert "3 of 8 directions" in answer.message
    assert "lift each foot once" in answer.message
    reported = world.until_reported("calibrator", "drift", "as calibrated: GRF is")
    assert reported.level == bytes([Level.OK])


def test_somebody_who_touches_the_robot_is_no_drift(world: World, robot: StandingRobot) -> None:
    start(world, rezero_time=0.5)
    robot.stand_as_modelled()
    assert set_calibration(world).success
    (left, right), pushes = robot.forces, cycle((-3.0, 3.0))

    def push() -> None:
        robot.forces = (left + next(pushes), right)

    world.node.create_timer(0.06, push)
    refused = rezero(world)
    assert not refused.success
    assert "nothing touches" in refused.message


# A whole job whose result must not be applied


def test_a_refused_result_comes_back_whole(world: World) -> None:
    robot = ObligingRobot(world, SUPPORT)
    start(world, motion="landmarks")
    world.until_reported("calibrator", "voltages", "come")
    world.until_reported("calibrator", "joints", "come")
    result = calibrate(world, supports=2, train=2).result()
    assert result.error_code == Calibrate.Result.NOT_APPLIED, result.message
    assert not result.success
    found = calibration_from_ros(result.calibration)
    assert found.verdict in {"WARN", "FAIL"}
    assert list_reasons(found.reasons) in result.message
    advice = f"shoe/apply shoecal_msgs/srv/Apply \"{{run_id: '{result.run_id}'}}\""
    assert (advice in result.message) == (found.verdict == "WARN")
    assert result.calibration.host == socket.gethostname()
    assert (result.calibration.simulated_time, result.calibration.device) == (
        False,
        "standing_robot",
    )
    kept = load_calibration(Path(result.session) / "calibration.yaml")
    assert (kept.id, kept.verdict, kept.reasons) == (found.id, found.verdict, found.reasons)
    np.testing.assert_array_equal(kept.parameters.gain, found.parameters.gain)
    assert in_force(world) == ""
    world.until_logged("calibrator", found.reasons[0])
    # Whoever moves the robot is told for which job.
    assert robot.run_ids == 4 * [result.run_id] != 4 * [""]
    # What only a recording needs was heard while it lasted.
    session = Session.open(Path(result.session))
    assert [len(session.read(entry.run).commanded) for entry in session.runs] == [1, 1]
