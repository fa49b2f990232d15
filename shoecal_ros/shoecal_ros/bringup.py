"""What the launch files start: decided and checked before the first node runs.

It needs no `launch`, so that it can be tried with the nodes alone.
"""

from __future__ import annotations

import os
import shlex
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ament_index_python.packages import PackageNotFoundError, get_package_prefix

from shoecal_core.end_with_parent import ending_with_parent
from shoecal_core.errors import NameNotFoundError, ShoecalError
from shoecal_core.parameter_file import sections_of
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workspace import config_dir
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.simulator.device_file import write_device

Parameter = str | bool | int | float
NONE = "none"
VIEWERS = {"rviz": "rviz2", "foxglove": "foxglove_bridge", "plotjuggler": "plotjuggler"}
"""Viewer -> the package that it is in."""
DEBIAN = {
    "rviz2": "ros-jazzy-rviz2",
    "foxglove_bridge": "ros-jazzy-foxglove-bridge",
    "plotjuggler": "ros-jazzy-plotjuggler-ros",
}
ADAPTERS = {
    "nao_lola": "nao_lola_adapter",
    "naoqi": "naoqi_adapter",
    "controller": "controller_adapter",
}
"""Argument -> node."""
TRUTHS = {"true": True, "1": True, "false": False, "0": False}


class MissingPackageError(ShoecalError):
    """A package that is asked for and not installed."""


@dataclass(frozen=True)
class NodeToStart:
    """One node of `shoecal_ros`.

    Attributes:
        name: of the node, its executable and its enclave.
        namespace: with its slash; empty for the root.
        files: parameter files.
        parameters: go before those of the files.
        enclave: for SROS2; empty: none.
    """

    name: str
    namespace: str
    files: tuple[Path, ...] = ()
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    enclave: str = ""

    @property
    def ros_arguments(self) -> list[str]:
        """Those that are neither names nor parameters."""
        return ["--enclave", self.enclave] if self.enclave else []


def ending_with_launch() -> str:
    """What goes before a command line, so that the program ends with this process, `launch`.

    Launch that gets SIGTERM, or is killed, leaves its nodes alone otherwise.
    """
    return shlex.join(ending_with_parent([]))


def robot_nodes(arguments: Mapping[str, str]) -> list[NodeToStart]:
    """The nodes started with a robot.

    Args:
        arguments: of `bringup.launch.py`.

    Raises:
        ShoecalError: for a viewer, an adapter or a file that is not there, or a parameter file
            that does not reach its node.
    """
    check_viewer(arguments["viewer"])
    adapter = _one_of("adapter", arguments["adapter"], ADAPTERS)
    robot = {"robot_file": arguments["robot"], "shoe_file": arguments["shoe"]}
    device = {"config_file": arguments["device"], "port": arguments["port"]}
    for name in ("robot", "shoe", "device"):
        if arguments[name] and not Path(arguments[name]).is_file():
            raise ShoecalError(f"{name}:={arguments[name]}: no such file; correct the argument")
    planner_file = str(Path(arguments["params"]) / "planner.yaml")
    folders = {}
    if arguments["state"]:
        state = Path(arguments["state"])
        folders = {"state_dir": str(state), "sessions_dir": str(state / "sessions")}
    nodes = [
        _node("shoe_driver", arguments, device, has_file=False),
        _node("model", arguments, robot),
        _node("planner", arguments, robot),
        _node("calibrator", arguments, {**robot, "planner_file": planner_file, **folders}),
    ]
    return [*nodes, _node(ADAPTERS[adapter], arguments, robot)] if adapter else nodes


def simulated_robot(arguments: Mapping[str, str]) -> NodeToStart:
    """The simulator.

    Args:
        arguments: of `demo.launch.py`.

    Raises:
        ShoecalError: as `robot_nodes`.
    """
    parameters: dict[str, Parameter] = {
        "robot_file": arguments["robot"],
        "shoe_file": arguments["shoe"],
        "reality_file": arguments["reality"],
        "seed": _number("seed", arguments["seed"], int),
        "speed": _number("speed", arguments["speed"], float),
        "port": simulated_port(arguments["namespace"]),
    }
    # It owns the clock, and does not hear it.
    return _node("simulator", {**arguments, "use_sim_time": "false"}, parameters)


def simulated_device(arguments: Mapping[str, str]) -> str:
    """The device file that the driver needs for the simulator: the cells of the shoe file.

    Args:
        arguments: of `demo.launch.py`.

    Raises:
        ShoecalError: for a shoe or reality file that cannot be used, or where the file cannot be
            written.
    """
    shoe = RobotFiles(robot_file=arguments["robot"], shoe_file=arguments["shoe"]).load_shoe()
    changes = Path(arguments["reality"]) if arguments["reality"] else None
    reality = load_reality(config_dir() / "realities" / "default.yaml", changes)
    port = Path(simulated_port(arguments["namespace"]))
    file = port.with_name(f"{port.name}.yaml")
    write_device(file, shoe, port, reality.cells.converter_bits)
    return str(file)


def simulated_port(namespace: str) -> str:
    """Link to the simulated serial port of a namespace in this ROS domain."""
    domain = os.environ.get("ROS_DOMAIN_ID", "")
    parts = ("shoecal_shoes", domain, *namespace.split("/"))
    return str(Path(tempfile.gettempdir()) / "_".join(filter(None, parts)))


def simulated_state(namespace: str) -> str:
    """Folder of the simulation's calibrations and sessions: never that of a real robot."""
    return str(Path("~/.ros/shoecal_demo") / namespace.strip("/"))


def check_viewer(name: str) -> str:
    """A viewer's name; empty for none.

    Raises:
        NameNotFoundError: for an unknown one.
        MissingPackageError: where its package is not installed.
    """
    viewer = _one_of("viewer", name, VIEWERS)
    if viewer:
        package = VIEWERS[viewer]
        try:
            get_package_prefix(package)
        except PackageNotFoundError as error:
            raise MissingPackageError(
                f"viewer:={viewer} needs the package {package}; sudo apt install {DEBIAN[package]}"
            ) from error
    return viewer


def _node(
    name: str,
    arguments: Mapping[str, str],
    parameters: Mapping[str, Parameter],
    *,
    has_file: bool = True,
) -> NodeToStart:
    namespace = arguments["namespace"].strip("/")
    namespace = f"/{namespace}" if namespace else ""
    files: tuple[Path, ...] = ()
    if has_file:
        files = (Path(arguments["params"]) / f"{name}.yaml",)
        sections_of(files[0], f"{namespace}/{name}")
    return NodeToStart(
        name,
        namespace,
        files,
        {**parameters, "use_sim_time": _truth("use_sim_time", arguments["use_sim_time"])},
        f"/shoecal/{name}" if _truth("enclaves", arguments["enclaves"]) else "",
    )


def _one_of(argument: str, value: str, known: Mapping[str, str]) -> str:
    """One of some names; empty for none."""
    if value in {"", NONE}:
        return ""
    if value not in known:
        raise NameNotFoundError(argument, value, (*known, NONE))
    return value


def _truth(argument: str, value: str) -> bool:
    if value.lower() not in TRUTHS:
        raise ShoecalError(f"{argument}:={value}: must be true or false")
    return TRUTHS[value.lower()]


def _number(argument: str, value: str, kind: type[int | float]) -> int | float:
    try:
        return kind(value)
    except ValueError as error:
        raise ShoecalError(f"{argument}:={value}: must be a number") from error
