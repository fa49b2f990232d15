"""Where things stand: the configuration, and the environment that ROS 2 processes need."""

from __future__ import annotations

import os
import sys
import sysconfig
from pathlib import Path

from shoecal_core.errors import ShoecalError

_RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
_PATH_LISTS = ("AMENT_PREFIX_PATH", "LD_LIBRARY_PATH", "PYTHONPATH")


def config_dir() -> Path:
    """The folder that holds `robots/`, `shoes/` and `nodes/`.

    SHOECAL_CONFIG names it where set; else it is the checkout's `config/` when this code runs
    from a checkout, else `share/shoecal_core/config` of the installed package.

    Raises:
        ShoecalError: when there is no such folder.
    """
    named = os.environ.get("SHOECAL_CONFIG")
    if named:
        if not Path(named).is_dir():
            raise ShoecalError(f"SHOECAL_CONFIG: no folder {named}; correct or unset it")
        return Path(named)
    checkout = _checkout()
    if checkout is not None:
        return checkout / "config"
    for prefix in (*_paths("AMENT_PREFIX_PATH"), Path(sys.prefix)):
        installed = prefix / "share" / "shoecal_core" / "config"
        if installed.is_dir():
            return installed
    raise ShoecalError(
        "no configuration folder found; source install/setup.bash or set SHOECAL_CONFIG"
    )


def network_environment() -> dict[str, str]:
    """How far nodes are seen: on this computer only, unless the environment says otherwise."""
    return {_RANGE: os.environ.get(_RANGE) or "LOCALHOST"}


def ros_environment() -> dict[str, str]:
    """Environment for a child process in which rclpy, shoecal_msgs and shoecal_ros import.

    Where this interpreter's own environment holds ROS 2 (as `make setup` builds it), the child
    gets that one whatever else is sourced, starts without the wheels' second start of the
    interpreter, and is seen as far as `network_environment` says. In a sourced workspace it is the
    environment as it stands.

    Raises:
        ShoecalError: where there is neither.
    """
    if _has_package(Path(sys.prefix), "rclpy"):
        return _wheels_environment(Path(sys.prefix))
    if any(_has_package(prefix, "shoecal_msgs") for prefix in _paths("AMENT_PREFIX_PATH")):
        return dict(os.environ)
    raise ShoecalError(
        "no ROS 2 workspace; run 'make setup' in the checkout or source install/setup.bash"
    )


def _wheels_environment(venv: Path) -> dict[str, str]:
    checkout = _checkout()
    if checkout is None or not _has_package(checkout / "install", "shoecal_msgs"):
        raise ShoecalError("the ROS 2 messages are not built; run 'make setup' in the checkout")
    environment = dict(os.environ)
    others = [
        prefix
        for prefix in _paths("AMENT_PREFIX_PATH")
        if prefix != venv and _has_package(prefix, "rclpy")
    ]
    for name in _PATH_LISTS:
        kept = [path for path in _paths(name) if not any(map(path.is_relative_to, others))]
        environment[name] = os.pathsep.join(map(str, kept))
    site = Path(sysconfig.get_path("purelib"))
    _prepend(environment, "AMENT_PREFIX_PATH", [checkout / "install", venv])
    _prepend(environment, "LD_LIBRARY_PATH", [venv / "lib", *sorted(site.glob("ros_*.libs"))])
    if not environment["PYTHONPATH"]:
        del environment["PYTHONPATH"]
    environment["RMW_IMPLEMENTATION"] = "rmw_fastrtps_cpp"
    environment["_ROS_WHEELS_BOOTSTRAP_COMPLETE"] = "1"
    return environment | network_environment()


def _checkout() -> Path | None:
    """Root of the checkout that this module runs from; None where it is installed."""
    root = Path(__file__).resolve().parents[2]
    return root if (root / "shoecal_msgs" / "package.xml").is_file() else None


def _has_package(prefix: Path, name: str) -> bool:
    return (prefix / "share" / "ament_index" / "resource_index" / "packages" / name).is_file()


def _paths(variable: str) -> list[Path]:
    return [Path(entry) for entry in os.environ.get(variable, "").split(os.pathsep) if entry]


def _prepend(environment: dict[str, str], variable: str, paths: list[Path]) -> None:
    ours = [str(path) for path in paths]
    rest = [entry for entry in environment[variable].split(os.pathsep) if entry not in ("", *ours)]
    environment[variable] = os.pathsep.join(ours + rest)
