from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import shoecal_core
from shoecal_core import workspace
from shoecal_core.errors import ShoecalError

CHECKOUT = Path(__file__).resolve().parents[2]


def mark(prefix: Path, package: str) -> Path:
    """Make a prefix hold a package, as the ament index sees it."""
    index = prefix / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True, exist_ok=True)
    (index / package).touch()
    return prefix


@pytest.fixture
def installed(tmp_path: Path) -> Path:
    """A site folder with a copy of the core, as colcon installs it."""
    site = tmp_path / "install/lib/python3/site-packages"
    source = Path(shoecal_core.__file__).parent
    for name in ("__init__.py", "errors.py", "workspace.py"):
        (site / "shoecal_core").mkdir(parents=True, exist_ok=True)
        shutil.copy(source / name, site / "shoecal_core")
    return site


def call(site: Path, function: str, prefix: Path | None = None, **environment: str) -> str:
    """What a function of an installed copy returns or raises, printed.

    The copy is put on the path by the program itself, so that it comes before all else.
    """
    program = (
        f"import sys; sys.path.insert(0, {str(site)!r}); sys.prefix = {str(prefix)!r}\n"
        "from shoecal_core import errors, workspace\n"
        f"try: print(workspace.{function}())\n"
        "except errors.ShoecalError as error: print('refused:', error)\n"
    )
    clean = {name: value for name, value in os.environ.items() if name != "AMENT_PREFIX_PATH"}
    done = subprocess.run(
        [sys.executable, "-c", program],
        env=clean | environment,
        check=True,
        capture_output=True,
        text=True,
    )
    return done.stdout.strip()


def test_in_a_checkout_its_own_configuration_is_used() -> None:
    assert workspace.config_dir() == CHECKOUT / "config"


def test_the_variable_names_another_configuration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHOECAL_CONFIG", str(tmp_path))
    assert workspace.config_dir() == tmp_path


def test_a_variable_that_names_no_folder_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SHOECAL_CONFIG", "/no/such/folder")
    with pytest.raises(ShoecalError, match="SHOECAL_CONFIG: no folder /no/such/folder"):
        workspace.config_dir()


def test_installed_the_configuration_is_found_in_the_workspace(
    installed: Path, tmp_path: Path
) -> None:
    config = tmp_path / "install/share/shoecal_core/config"
    config.mkdir(parents=True)
    prefixes = f"/opt/none{os.pathsep}{tmp_path / 'install'}"
    assert call(installed, "config_dir", AMENT_PREFIX_PATH=prefixes) == str(config)


def test_without_a_configuration_the_error_names_the_cure(installed: Path) -> None:
    assert call(installed, "config_dir").startswith(
        "refused: no configuration folder found; source"
    )


def test_a_sourced_workspace_is_left_as_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "prefix", str(tmp_path / "no_wheels"))
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(mark(tmp_path / "install", "shoecal_msgs")))
    assert workspace.ros_environment() == dict(os.environ)


def test_without_ros_the_error_names_the_cure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    with pytest.raises(ShoecalError, match="run 'make setup' in the checkout or source"):
        workspace.ros_environment()


def test_messages_that_are_not_built_are_named(installed: Path, tmp_path: Path) -> None:
    answer = call(installed, "ros_environment", prefix=mark(tmp_path, "rclpy"))
    assert answer.startswith("refused: the ROS 2 messages are not built; run 'make setup'")


def test_nodes_are_seen_on_this_computer_unless_told_otherwise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    name = "ROS_AUTOMATIC_DISCOVERY_RANGE"
    monkeypatch.delenv(name, raising=False)
    assert workspace.network_environment() == {name: "LOCALHOST"}
    for given, taken in (("", "LOCALHOST"), ("SUBNET", "SUBNET"), ("OFF", "OFF")):
        monkeypatch.setenv(name, given)
        assert workspace.network_environment() == {name: taken}
