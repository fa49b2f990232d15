"""Packages hold what they must, name what they need, and agree on their version."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
import yaml

from docs.pages import ROOT

PACKAGES = ("shoecal_core", "shoecal_msgs", "shoecal_ros")
ROSDEP_KEYS = {
    "casadi-pip", "mcap-ros2-support", "python3-hypothesis", "python3-jinja2",
    "python3-matplotlib", "python3-mujoco-pip", "python3-numpy", "python3-pytest",
    "python3-pytest-timeout", "python3-rich", "python3-rosbags-pip", "python3-scipy",
    "python3-serial", "python3-shapely", "python3-yaml",
}  # fmt: skip
"""Looked up in rosdep/python.yaml and base.yaml of ros/rosdistro, August 2026: each has a rule for
Ubuntu. A new one belongs here once it has been looked up there."""
ROS_PACKAGES = {
    "action_msgs", "ament_cmake", "ament_index_python", "builtin_interfaces", "coal",
    "control_msgs", "diagnostic_msgs",
    "geometry_msgs", "launch", "launch_ros", "pinocchio", "rcl_interfaces", "rclpy",
    "robot_state_publisher", "rosgraph_msgs", "rosidl_default_generators",
    "rosidl_default_runtime", "sensor_msgs", "std_msgs", "std_srvs", "tf2_msgs",
    "trajectory_msgs", "visualization_msgs",
}  # fmt: skip
"""Released into Jazzy: jazzy/distribution.yaml, at the same time."""
KEY_OF_IMPORT = {
    "casadi": ("casadi", "casadi-pip"),
    "coal": ("coal", "coal"),
    "jinja2": ("jinja2", "python3-jinja2"),
    "markupsafe": ("markupsafe", "python3-jinja2"),
    "matplotlib": ("matplotlib", "python3-matplotlib"),
    "mcap": ("mcap", "mcap-ros2-support"),
    "mcap_ros2": ("mcap-ros2-support", "mcap-ros2-support"),
    "mujoco": ("mujoco", "python3-mujoco-pip"),
    "numpy": ("numpy", "python3-numpy"),
    "pinocchio": ("pin", "pinocchio"),
    "rich": ("rich", "python3-rich"),
    "rosbags": ("rosbags", "python3-rosbags-pip"),
    "scipy": ("scipy", "python3-scipy"),
    "serial": ("pyserial", "python3-serial"),
    "shapely": ("shapely", "python3-shapely"),
    "yaml": ("pyyaml", "python3-yaml"),
    "zstandard": ("zstandard", "mcap-ros2-support"),
}
"""What is imported, by its name on PyPI and its rosdep key."""
OPTIONAL = {"distributed", "shtab", "tf2_msgs"}
"""Imported only where they are."""


@cache
def manifest(package: str) -> ET.Element:
    return ET.parse(ROOT / package / "package.xml").getroot()


def needed(package: str) -> set[str]:
    return {str(tag.text) for tag in manifest(package) if tag.tag.endswith("depend")}


def imported(folder: Path) -> Iterator[str]:
    for file in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.Import):
                yield from (alias.name.split(".")[0] for alias in node.names)
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                yield node.module.split(".")[0]


def test_versions_agree() -> None:
    (version,) = {manifest(package).findtext("version") for package in PACKAGES}
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == version
    changes = (ROOT / "CHANGELOG.md").read_text()
    sections = re.findall(r"^## (.*)$", changes, re.MULTILINE)
    assert sections[0] == "Unreleased"
    dated = [re.fullmatch(r"(\d+\.\d+\.\d+) - \d{4}-\d\d-\d\d", one) for one in sections[1:]]
    assert all(dated)
    assert dated[0] is not None
    assert dated[0].group(1) == version


@pytest.mark.parametrize("package", PACKAGES)
def test_needs_are_known_to_rosdep(package: str) -> None:
    assert not needed(package) - ROSDEP_KEYS - ROS_PACKAGES - set(PACKAGES)


@pytest.mark.parametrize("package", ["shoecal_core", "shoecal_ros"])
def test_what_is_imported_is_needed(package: str) -> None:
    declared = (ROOT / package / "setup.py").read_text().lower()
    for name in (
        set(imported(ROOT / package / package))
        - set(sys.stdlib_module_names)
        - OPTIONAL
        - {package}
    ):
        on_pypi, key = KEY_OF_IMPORT.get(name, ("", name))
        if package == "shoecal_ros" and key in needed("shoecal_core"):
            continue
        assert key in needed(package), f"{package}/package.xml lacks {key}"
        assert f'"{on_pypi}' in declared, f"{package}/setup.py lacks {on_pypi}"


@pytest.mark.parametrize("package", ["shoecal_core", "shoecal_ros"])
def test_what_rosdep_takes_from_pypi_is_no_version_of_its_own(package: str) -> None:
    """It installs the newest, so a package that asks for another one would not start."""
    declared = (ROOT / package / "setup.py").read_text().lower()
    from_pypi = [name for name, key in KEY_OF_IMPORT.values() if key.endswith("-pip")]
    assert from_pypi
    assert not [name for name in from_pypi if f'"{name}==' in declared]


@pytest.mark.parametrize("package", ["shoecal_core", "shoecal_ros"])
def test_what_tests_import_is_needed(package: str) -> None:
    """So that `rosdep install` brings what `colcon test` takes."""
    beside = {
        path.stem for part in ("benchmarks", "scripts", "test") for path in (ROOT / part).iterdir()
    }
    own = {*beside, *PACKAGES} | OPTIONAL | set(sys.stdlib_module_names)
    known = needed(package) | needed("shoecal_core") | {"python3-pytest"}
    tests = ROOT / "test" / package.removeprefix("shoecal_")
    for name in set(imported(tests)) - own:
        _, key = KEY_OF_IMPORT.get(name, ("", f"python3-{name}"))
        assert name in known or key in known, f"{package}/package.xml lacks {key} ({name})"


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> zipfile.Path:
    """shoecal_core's, built without a network from a copy: building leaves things behind."""
    folder = tmp_path_factory.mktemp("wheel")
    ignored = shutil.ignore_patterns("__pycache__", "*.egg-info", "build")
    shutil.copytree(ROOT / "shoecal_core", folder / "source", ignore=ignored)
    subprocess.run(
        [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation",
         "--no-index", "--disable-pip-version-check", "--wheel-dir", folder, folder / "source"],
        check=True, timeout=200,
    )  # fmt: skip
    (file,) = folder.glob("*.whl")
    return zipfile.Path(file)


def test_wheel_holds_what_it_must(wheel: zipfile.Path) -> None:
    names = set(wheel.root.namelist())
    package = ROOT / "shoecal_core" / "shoecal_core"
    files = [file for file in package.rglob("*") if file.is_file() and file.suffix != ".pyc"]
    assert not {f"shoecal_core/{file.relative_to(package)}" for file in files} - names
    assert "shoecal_core/py.typed" in names
    version = manifest("shoecal_core").findtext("version")
    share = f"shoecal_core-{version}.data/data/share/shoecal_core"
    config = [file for file in (ROOT / "config").rglob("*") if file.is_file()]
    assert not {f"{share}/config/{file.relative_to(ROOT / 'config')}" for file in config} - names
    metadata = {name.rpartition("/")[2] for name in names if ".dist-info/" in name}
    assert {"LICENSE", "entry_points.txt"} <= metadata
    assert not [name for name in names if name.startswith(("test", "config")) or ".pyc" in name]


def test_colcon_test_finds_the_tests(tmp_path: Path) -> None:
    colcon = Path(sys.prefix) / "bin" / "colcon"
    if not colcon.exists() or not (ROOT / "install").exists():
        pytest.skip("no workspace is built here")
    environment = os.environ | {
        "PATH": f"{sys.prefix}/bin:{os.environ['PATH']}", "COLCON_HOME": str(tmp_path),
    }  # fmt: skip
    tested = subprocess.run(
        [colcon, "--log-base", tmp_path / "log", "test", "--merge-install", "--base-paths",
         ROOT / "shoecal_core", "--build-base", ROOT / "build", "--install-base", ROOT / "install",
         "--test-result-base", tmp_path, "--return-code-on-test-failure",
         "--pytest-args", "../test/core/test_settings.py"],
        cwd=ROOT, env=environment, capture_output=True, text=True, timeout=240, check=False,
    )  # fmt: skip
    assert tested.returncode == 0, tested.stdout + tested.stderr
    result = ET.parse(tmp_path / "shoecal_core" / "pytest.xml").getroot()
    suite = result if result.tag == "testsuite" else result[0]
    assert int(suite.attrib["tests"]) > 5
