from __future__ import annotations

import ast
import contextlib
import importlib.util
import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest
from rcl_interfaces.srv import GetParameters
from shoecal_msgs.msg import ShoeVoltages
from trajectory_msgs.msg import JointTrajectory

from core.stranger import Stranger
from reference.launch_files import arguments as listed
from ros.bodies import ODD, ODD_SHOE
from ros.world import World
from shoecal_core.errors import ShoecalError
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.workspace import config_dir, ros_environment
from shoecal_ros.bringup import (
    NodeToStart,
    robot_nodes,
    simulated_device,
    simulated_port,
    simulated_robot,
    simulated_state,
)
from shoecal_ros.common import qos

LAUNCH = Path(__file__).parents[2] / "shoecal_ros/launch"
LIMIT = 0.11


def arguments(file: str, **changes: str) -> dict[str, str]:
    """As a launch file has them where nothing else is asked for."""
    tree = ast.parse((LAUNCH / f"{file}.launch.py").read_text())
    config = str(config_dir())
    defaults = {name: text.replace("CONFIG", config, 1) for name, (text, _) in listed(tree)}
    return defaults | changes


def ros_arguments(node: NodeToStart) -> list[str]:
    """Those that `launch_ros` gives a node."""
    files = [part for path in node.files for part in ("--params-file", str(path))]
    remaps = ["-r", f"__node:={node.name}", "-r", f"__ns:={node.namespace or '/'}"]
    pairs = [f"{name}:={json.dumps(value)}" for name, value in node.parameters.items()]
    own = [part for pair in pairs for part in ("-p", pair)]
    return [*remaps, *files, *own, *node.ros_arguments]


def begin(world: World, node: NodeToStart) -> None:
    world.start(node.name, {}, *ros_arguments(node))


def own_parameters(folder: Path) -> Path:
    """A folder of parameter files with a limit of one's own."""
    shutil.copytree(config_dir() / "nodes", folder)
    file = folder / "planner.yaml"
    text = file.read_text()
    assert "    follow_error: 0.12 " in text
    file.write_text(text.replace("    follow_error: 0.12 ", f"    follow_error: {LIMIT} "))
    return folder


def test_a_demo_in_a_namespace_keeps_its_limits_and_takes_the_simulator_along(
    world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    common = {
        "params": str(own_parameters(tmp_path / "nodes")),
        "namespace": "/left",
        "robot": str(ODD),
        "shoe": str(ODD_SHOE),
    }
    demo = arguments("demo", **common)
    robot = arguments(
        "bringup",
        device=simulated_device(demo),
        use_sim_time="true",
        state=str(tmp_path / "state"),
        **common,
    )
    for node in (simulated_robot(demo), *robot_nodes(robot)):
        begin(world, node)
    voltages = world.receive(ShoeVoltages, "left/shoe/voltages", qos.EITHER)
    world.until(lambda: len(voltages) > 3)
    assert tuple(voltages.last.cell) == load_shoe(ODD_SHOE).names
    world.publisher(JointTrajectory, "left/joint_trajectory", qos.COMMAND)
    request = GetParameters.Request(names=["follow_error"])
    (value,) = world.call(GetParameters, "left/planner/get_parameters", request).values
    assert value.double_value == LIMIT
    request = GetParameters.Request(names=["state_dir", "sessions_dir"])
    folders = world.call(GetParameters, "left/calibrator/get_parameters", request).values
    assert [one.string_value for one in folders] == [
        str(tmp_path / "state"), str(tmp_path / "state" / "sessions"),
    ]  # fmt: skip


STAND_IN = """
import os, shlex, subprocess, sys
from shoecal_ros.bringup import ending_with_launch
# As somebody has it who has sourced nothing: the wheels start the interpreter a second time.
environment = {**os.environ}
del environment["_ROS_WHEELS_BOOTSTRAP_COMPLETE"]
for line in sys.stdin:
    command = [*shlex.split(ending_with_launch()), *shlex.split(line)]
    print(subprocess.Popen(command, env=environment).pid, flush=True)
"""
"""Starts what it is told as launch does, and does nothing at SIGTERM."""


@pytest.mark.skipif(
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE" not in ros_environment(), reason="needs the wheels"
)
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_nodes_end_with_the_launch_that_is_terminated(
    world: World, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    demo = arguments("demo")
    robot = arguments(
        "bringup", device=simulated_device(demo), use_sim_time="true", state=str(tmp_path / "state")
    )
    nodes = [simulated_robot(demo), *robot_nodes(robot)]
    with (
        subprocess.Popen(
            [sys.executable, "-c", STAND_IN], env=ros_environment(), text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=(tmp_path / "log").open("w"),
        ) as launch,
        contextlib.ExitStack() as strangers,
    ):  # fmt: skip
        assert launch.stdin is not None
        assert launch.stdout is not None
        children = []
        for node in nodes:
            program = [sys.executable, "-m", f"shoecal_ros.nodes.{node.name}", "--ros-args"]
            print(shlex.join([*program, *ros_arguments(node)]), file=launch.stdin, flush=True)
            children.append(strangers.enter_context(Stranger(int(launch.stdout.readline()))))
        world.until_reported("planner", "planning", "ready")
        world.until_reported("calibrator", "voltages", "voltages come")
        launch.send_signal(number)
        assert all(child.ends() for child in children)
    # They were asked to, and did the rest themselves.
    assert "Traceback" not in (tmp_path / "log").read_text()


def test_a_simulation_has_state_and_port_of_its_own() -> None:
    states = [simulated_state(""), simulated_state("/left"), simulated_state("/right")]
    assert len({"~/.ros/shoecal", *states}) == 4
    assert len({simulated_port(one) for one in ("", "left", "left/a", "right")}) == 4
    assert simulated_port("/left/") == simulated_port("left")


def test_another_ros_domain_has_another_simulated_port(monkeypatch: pytest.MonkeyPatch) -> None:
    ports = set()
    for domain in ("", "7", "8"):
        monkeypatch.setenv("ROS_DOMAIN_ID", domain)
        ports.add(simulated_port("left"))
    assert len(ports) == 3


def test_what_a_parameter_file_says_of_folders_stays(tmp_path: Path) -> None:
    calibrator = robot_nodes(arguments("bringup"))[3]
    assert "state_dir" not in calibrator.parameters
    moved = robot_nodes(arguments("bringup", state=str(tmp_path)))[3]
    assert moved.parameters["state_dir"] == str(tmp_path)


def test_an_adapter_is_started_beside_them() -> None:
    nodes = robot_nodes(arguments("bringup", adapter="naoqi", namespace="left"))
    assert nodes[-1].name == "naoqi_adapter"
    assert {node.namespace for node in nodes} == {"/left"}


def test_every_node_gets_its_enclave() -> None:
    nodes = robot_nodes(arguments("bringup", adapter="controller", enclaves="true"))
    nodes.append(simulated_robot(arguments("demo", enclaves="true")))
    for node in nodes:
        assert node.ros_arguments == ["--enclave", f"/shoecal/{node.name}"]
    assert not robot_nodes(arguments("bringup"))[0].ros_arguments


BAD = {
    "an unknown viewer": ({"viewer": "blender"}, "no viewer named 'blender' (there are: rviz"),
    "a viewer that is not installed": (
        {"viewer": "rviz"}, "viewer:=rviz needs the package rviz2; sudo apt install",
    ),
    "an unknown adapter": ({"adapter": "naoqy"}, "did you mean 'naoqi'?"),
    "no folder of parameters": ({"params": "/nowhere"}, "/nowhere/model.yaml"),
    "no robot": ({"robot": "/nowhere.yaml"}, "robot:=/nowhere.yaml: no such file"),
    "neither true nor false": ({"use_sim_time": "maybe"}, "must be true or false"),
}  # fmt: skip


@pytest.mark.parametrize(("changes", "reported"), BAD.values(), ids=BAD)
def test_what_is_wrong_is_found_before_a_node_starts(
    changes: dict[str, str], reported: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AMENT_PREFIX_PATH", ros_environment()["AMENT_PREFIX_PATH"])
    if importlib.util.find_spec("rviz2") or shutil.which("rviz2"):
        pytest.skip("a viewer is installed here")
    with pytest.raises(ShoecalError) as caught:
        robot_nodes(arguments("bringup", **changes))
    assert reported in str(caught.value)


def test_a_parameter_file_that_misses_its_node_is_found(tmp_path: Path) -> None:
    folder = own_parameters(tmp_path / "nodes")
    file = folder / "planner.yaml"
    file.write_text(file.read_text().replace("/**/planner:", "planner:"))
    assert len(robot_nodes(arguments("bringup", params=str(folder)))) == 4
    with pytest.raises(ShoecalError, match="sets nothing of node /left/planner"):
        robot_nodes(arguments("bringup", params=str(folder), namespace="left"))


@pytest.mark.parametrize(
    "file_and_argument",
    [("bringup", "viewer:=blender"), ("demo", "viewer:=blender"), ("view", "viewer:=blender")],
)
def test_launch_itself_tells_it_and_leaves_nothing(
    file_and_argument: tuple[str, str], tmp_path: Path
) -> None:
    pytest.importorskip("launch_ros", reason="needs launch and launch_ros, which have no wheels")
    file, argument = file_and_argument
    program = (
        "import sys; from launch import LaunchService; "
        "from launch.actions import IncludeLaunchDescription as Include; "
        "from launch.launch_description_sources import PythonLaunchDescriptionSource as Source; "
        "from launch import LaunchDescription as Description; "
        "service = LaunchService(argv=sys.argv[2:]); "
        "pairs = [one.split(':=') for one in sys.argv[2:]]; "
        "service.include_launch_description(Description("
        "[Include(Source(sys.argv[1]), launch_arguments=pairs)])); "
        "sys.exit(service.run())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(LAUNCH / f"{file}.launch.py"), argument],
        env={**ros_environment(), "PYTHONPATH": os.pathsep.join(sys.path), "HOME": str(tmp_path)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 1
    assert "no viewer named 'blender'" in done.stderr + done.stdout
    assert "process started" not in done.stderr + done.stdout
