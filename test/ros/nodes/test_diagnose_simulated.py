"""Action `shoe/diagnose` with the simulated robot: recorded, cancelled, diagnosed, gone on with."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from shoecal_msgs.action import Diagnose
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory

from ros.bodies import nao_shoe
from ros.rest import until_still
from ros.world import Goal, World
from shoecal_core.diagnosis.result import VERDICT_TEXTS
from shoecal_core.recording.session import Session
from shoecal_ros.calibrator.proposals import by_hand
from shoecal_ros.common import qos
from shoecal_ros.common.conversions import time_from_ros
from shoecal_ros.simulator.device_file import write_device

CODES = Diagnose.Result
QUICK = {
    "follow_late": 4.0,
    "planning.horizon": 5,
    "planning.landmark_radius": 0.012,
    "planning.com_speed": 0.03,
}
"""Shorter planning and motions, and patience on a busy machine."""
MOTIONS = ("landmarks", "reversed", "landmarks")


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> Iterator[World]:
    """All nodes but the model."""
    with World(tmp_path_factory.mktemp("simulated")) as world:
        port, device = world.folder / "port", world.folder / "device.yaml"
        write_device(device, nao_shoe(), port, 24)
        world.start("simulator", {"port": port, "speed": 5.0})
        world.start("shoe_driver", {"use_sim_time": True, "config_file": device})
        world.start("planner", {"use_sim_time": True, "stale_s": 10.0, **QUICK})
        folders = {"state_dir": world.folder / "state", "sessions_dir": world.folder / "sessions"}
        world.start("calibrator", {"use_sim_time": True, "stale_s": 10.0, **folders})
        world.until_reported("planner", "planning", "ready")
        for subject in ("voltages", "joints"):
            world.until_reported("calibrator", subject, "come")
        yield world


def arm(world: World, armed: bool = True) -> None:
    assert world.call(SetBool, "shoe/arm", SetBool.Request(data=armed)).success


def diagnose(world: World, **goal: object) -> Goal:
    return world.goal(Diagnose, "shoe/diagnose", Diagnose.Goal(**{"seed": -1, **goal}))


def reported(goal: Goal, phase: str) -> bool:
    assert not goal.done, goal.result().message
    return any(one.phase == phase for one in goal.feedback)


def test_cancelled_while_it_records_the_robot_stops_gently(world: World) -> None:
    arm(world)
    commands = world.receive(JointTrajectory, "joint_trajectory", qos.COMMAND)
    world.until_discovered_by("planner")
    goal = diagnose(world, motions=["landmarks"])
    world.until(lambda: reported(goal, "moving"))
    goal.cancel()
    result = goal.result()
    assert result.error_code == CODES.CANCELED
    world.until(lambda: len(commands) == 2)
    (end,) = commands.last.points
    assert time_from_ros(end.time_from_start) == pytest.approx(0.5e9)
    until_still(world)
    session = Session.open(Path(result.session))
    assert not session.runs
    assert [path.name for path in session.unfinished] == ["run_001.mcap.part"]
    world.until_reported("calibrator", "diagnosis", "ended: cancelled")


@pytest.fixture(scope="module")
def whole(world: World) -> Goal:
    """A short list of motions, recorded and diagnosed, and what was proposed then."""
    arm(world)
    goal = diagnose(world, motions=list(MOTIONS), run_proposed=True)
    goal.result()
    return goal


def test_motions_are_recorded_and_diagnosed(whole: Goal) -> None:
    result = whole.result()
    assert (result.success, result.error_code) == (True, CODES.OK), result.message
    phases = list(dict.fromkeys(one.phase for one in whole.feedback))
    assert phases == ["drawing", "reaching", "planning", "moving", "diagnosing"]
    progress = [one.progress for one in whole.feedback]
    assert progress == sorted(progress)
    assert 0.0 <= progress[0] < 0.1
    assert progress[-1] <= 1.0
    assert result.verdict in VERDICT_TEXTS
    found = json.loads(result.json)
    assert found["verdict"] == result.verdict
    folder = Path(result.session)
    assert json.loads((folder / "diagnosis.json").read_text()) == found
    assert Path(result.report) == folder / "diagnosis.html"
    assert "<html" in Path(result.report).read_text()
    runs = Session.open(folder).runs
    assert [entry.info.motion for entry in runs[:3]] == list(MOTIONS)
    assert len({entry.info.support for entry in runs[:3]}) == 3


def test_the_proposed_motion_is_run_unless_it_needs_a_person(whole: Goal) -> None:
    result = whole.result()
    added = [entry.info.motion for entry in Session.open(Path(result.session)).runs[3:]]
    if added:
        assert f", after {added[0]} {result.verdict}" in result.message
        assert not by_hand(added[0])
    else:
        assert result.message.startswith(result.verdict)
        assert not result.proposed or by_hand(result.proposed)
    if result.proposed:
        assert f"motions: [{result.proposed}]" in result.message


def test_a_recorded_session_needs_no_arming_and_the_search_is_cancelled(
    world: World, whole: Goal
) -> None:
    arm(world, armed=False)
    folder = Path(whole.result().session)
    refused = diagnose(world, session=folder.name, run_proposed=True).result()
    assert refused.error_code == CODES.NOT_ARMED
    before = Session.open(folder).runs
    goal = diagnose(world, session=folder.name)
    world.until(lambda: reported(goal, "diagnosing"))
    goal.cancel()
    result = goal.result()
    assert (result.error_code, result.session) == (CODES.CANCELED, str(folder))
    assert not result.json
    assert {one.phase for one in goal.feedback} == {"diagnosing"}
    assert Session.open(folder).runs == before
