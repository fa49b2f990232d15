"""Forces that the standing robot contradicts are never valid; those of a healthy robot are."""

from __future__ import annotations

import pytest
from shoecal_msgs.msg import ShoeForces, ShoeState
from shoecal_msgs.srv import Rezero, SetCalibration
from std_srvs.srv import Trigger

from ros.bodies import nao
from ros.nodes.calibrations import (
    COUNT,
    SHOE,
    STATED,
    SUPPORT,
    any_valid,
    apply,
    healthy,
    law,
    made,
    start,
    until,
    usable,
)
from ros.standing_robot import StandingRobot
from ros.world import World
from shoecal_core.estimation.calibration import save_calibration
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import calibration_to_ros, time_from_ros

SECOND_NS = 10**9
IN_TIME_NS = 2 * SECOND_NS


def test_a_refusal_names_figures_and_cure_and_force_flags(world: World) -> None:
    StandingRobot(world, SUPPORT).stand_as_modelled()
    start(world)
    assert apply(world, calibration_to_ros(healthy())).success
    world.until_reported("calibrator", "agreement", "agrees with the robot")
    refused = apply(world, made(parameters=law(1.15)))
    assert refused.error_code == SetCalibration.Response.NOT_APPLICABLE
    for part in ("contradicts the standing robot: GRF is +", "N off the weight", "with force"):
        assert part in refused.message
    forced = apply(world, made(parameters=law(1.15)), force=True)
    assert forced.success, forced.message
    assert forced.disagrees
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    last = until(world, forces, lambda one: one.calibration == "wrong", "forces by it")
    assert last.disagrees
    assert not any_valid(last)
    # What was in force before is right again.
    assert world.call(Trigger, "shoe/rollback", Trigger.Request()).success
    until(world, forces, usable, "valid forces")
    refused = world.call(Trigger, "shoe/rollback", Trigger.Request())
    assert not refused.success
    assert "contradicts the standing robot" in refused.message


def test_what_a_hanging_robot_takes_is_unconfirmed_until_it_stands(world: World) -> None:
    robot = StandingRobot(world, SUPPORT)
    robot.forces, robot.waving = (0.0, 0.0), True
    start(world)
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    state = world.receive(ShoeState, "shoe/state", qos.LATCHED)
    answer = apply(world, calibration_to_ros(healthy()))
    assert answer.success
    assert answer.unconfirmed
    assert "let the robot stand" in answer.message
    until(world, forces, lambda one: one.unconfirmed, "the flag")
    until(world, state, lambda one: one.unconfirmed, "the flag")
    assert not any(any_valid(one) for one in forces.messages)
    robot.forces = (25.0, nao().weight - 25.0)
    stood_ns = robot.stamp_ns
    first = until(world, forces, usable, "valid forces")
    assert time_from_ros(first.header.stamp) - stood_ns <= IN_TIME_NS
    until(world, state, lambda one: not one.unconfirmed and one.feet[0].valid, "the same")
    assert not any(one.disagrees for one in forces.messages)


def test_a_wrong_file_at_the_start_is_never_valid(world: World) -> None:
    robot = StandingRobot(world, SUPPORT)
    robot.stand_as_modelled()
    folder = world.folder / "state"
    folder.mkdir()
    save_calibration(healthy("wrong", parameters=law(1.15)), folder / "calibration.yaml")
    start(world)
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    until(world, forces, lambda one: one.disagrees, "the flag")
    assert {one.calibration for one in forces.messages} == {"wrong"}
    assert not any(any_valid(one) for one in forces.messages)
    world.until_reported("calibrator", "agreement", "contradicted by the robot")


@pytest.mark.parametrize("stated", [None, 1e-3, 1.0, 1e2])
def test_what_goes_wrong_later_is_not_valid_within_two_seconds(
    world: World, stated: float | None
) -> None:
    robot = StandingRobot(world, SUPPORT)
    robot.stand_as_modelled()
    start(world)
    covariance = None if stated is None else stated * STATED
    assert apply(world, calibration_to_ros(healthy(covariance=covariance))).success
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    state = world.receive(ShoeState, "shoe/state", qos.LATCHED)
    until(world, forces, usable, "valid forces")
    robot.drift[2] = 4.0
    wrong_ns = robot.stamp_ns
    first = until(world, forces, lambda one: not any_valid(one), "forces that are not valid")
    assert first.disagrees
    assert time_from_ros(first.header.stamp) - wrong_ns <= IN_TIME_NS
    flagged = until(world, state, lambda one: one.disagrees, "the flag of the state")
    assert not any(foot.valid for foot in flagged.feet)
    answer = world.call(Rezero, "shoe/rezero", Rezero.Request())
    assert answer.success, answer.message
    until(world, forces, lambda one: usable(one) and not one.disagrees, "valid forces")


def test_what_is_off_by_less_is_flagged_and_valid(world: World) -> None:
    robot = StandingRobot(world, SUPPORT)
    robot.stand_as_modelled()
    start(world)
    assert apply(world, calibration_to_ros(healthy(covariance=0.01 * STATED))).success
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    until(world, forces, usable, "valid forces")
    robot.drift[:] = 0.03 * nao().weight / COUNT
    wrong_ns = robot.stamp_ns
    flagged = until(world, forces, lambda one: one.disagrees, "the flag")
    assert time_from_ros(flagged.header.stamp) - wrong_ns <= IN_TIME_NS
    assert usable(flagged)
    world.until_reported("calibrator", "agreement", "disagrees with the robot: GRF is +1.6")


def test_a_healthy_robot_is_never_accused(world: World) -> None:
    """It stands, moves its arms, shifts all load to one foot, hangs, and stands again."""
    robot = StandingRobot(world, SUPPORT)
    robot.stand_as_modelled()
    start(world)
    assert apply(world, calibration_to_ros(healthy(covariance=0.01 * STATED))).success
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    first = until(world, forces, usable, "valid forces")
    begun = forces.messages.index(first)
    stood, weight = robot.forces, nao().weight

    def go_on(seconds: int) -> None:
        end_ns = robot.stamp_ns + seconds * SECOND_NS
        until(world, forces, lambda one: time_from_ros(one.header.stamp) > end_ns, "time to pass")

    go_on(2)
    robot.waving = robot.modelled = True
    go_on(2)
    robot.modelled = False
    for left in (0.75 * weight, weight, 0.5 * weight, 0.0):
        robot.forces = (left, weight - left)
        go_on(1)
    robot.forces = (0.0, 0.0)
    go_on(2)
    robot.forces = stood
    go_on(2)
    for message in forces.messages[begun:]:
        assert not message.disagrees
        assert not message.unconfirmed
        assert usable(message)


def test_readings_that_are_not_good_confirm_nothing(world: World) -> None:
    robot = StandingRobot(world, SUPPORT)
    robot.stand_as_modelled()
    robot.status = {SHOE.names[0]: 1}
    start(world)
    assert apply(world, calibration_to_ros(healthy())).unconfirmed
    forces = world.receive(ShoeForces, "shoe/forces", qos.LIVE)
    end_ns = robot.stamp_ns + IN_TIME_NS
    until(world, forces, lambda one: time_from_ros(one.header.stamp) > end_ns, "time to pass")
    assert forces.last.unconfirmed
    robot.status = {}
    until(world, forces, usable, "valid forces")
