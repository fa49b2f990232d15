"""What `make setup` says where it cannot go on, and how it mends the wheels of ROS 2."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout that set-up must leave as it is."""
    shutil.copytree(SCRIPTS, tmp_path / "scripts")
    shutil.copy(SCRIPTS.parent / "requirements.txt", tmp_path)
    return tmp_path


def python_that_is(folder: Path, otherwise: str) -> str:
    """An interpreter that finds itself changed by a statement."""
    script = folder / "python"
    script.write_text(
        f'#!/bin/sh\n{{ echo "import sys; {otherwise}"; cat; }} | exec {sys.executable} -\n'
    )
    script.chmod(0o755)
    return str(script)


def refusal(checkout: Path, **environment: str) -> str:
    done = subprocess.run(
        [checkout / "scripts/setup.sh"],
        env=os.environ | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert not (checkout / ".venv").exists()
    (line,) = done.stderr.splitlines()
    return line


@pytest.mark.parametrize(
    ("otherwise", "cure"),
    [
        ("sys.version_info = (3, 8, 10)", "install one and call make setup PYTHON="),
        ("sys.version_info = (3, 14, 0)", "Python 3.11 to 3.13 is needed"),
        ("sys.modules['ensurepip'] = None", "sudo apt install python3.11-venv"),
        (
            "import sysconfig; sysconfig.get_path = lambda name: '/nowhere'",
            "sudo apt install python3.11-dev",
        ),
        ("sys.exit(1)", "sudo apt install python3"),
    ],
)
def test_an_interpreter_that_does_not_do(
    checkout: Path, tmp_path_factory: pytest.TempPathFactory, otherwise: str, cure: str
) -> None:
    statement = f"sys.version_info = (3, 11, 2); {otherwise}"
    python = python_that_is(tmp_path_factory.mktemp("bin"), statement)
    assert cure in refusal(checkout, PYTHON=python)


def test_no_compiler(checkout: Path) -> None:
    assert refusal(checkout, CXX="no-such-compiler -O2") == (
        "setup: no-such-compiler is missing; sudo apt install build-essential"
    )


def test_wheels_are_mended_once(tmp_path: Path) -> None:
    spec = importlib.util.spec_from_file_location("fix_ros_wheels", SCRIPTS / "fix_ros_wheels.py")
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    exported = tmp_path / "std_msgs/cmake/export_std_msgs__rosidl_generator_pyExport.cmake"
    exported.parent.mkdir(parents=True)
    exported.write_text(
        'INTERFACE_INCLUDE_DIRECTORIES "/opt/python/cp312-cp312/include/python3.12;'
        "${_IMPORT_PREFIX}/include;"
        '/opt/python/cp312-cp312/lib/python3.12/site-packages/numpy/_core/include"\n'
    )
    headers = {script.PYTHON_HEADERS: r"/usr/include/python3\1", script.NUMPY_HEADERS: "/np"}
    assert script.fix(tmp_path, headers) == 1
    assert exported.read_text() == (
        r'INTERFACE_INCLUDE_DIRECTORIES "/usr/include/python3\1;${_IMPORT_PREFIX}/include;/np"'
        "\n"
    )
    assert script.fix(tmp_path, headers) == 0
