"""Set-up: what it installs, what it says where it cannot go on, how it mends the ROS 2 wheels."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"
LOCKS = [
    "requirements.txt", "requirements-floor.txt", "requirements-docs.txt",
    "requirements-robots.txt",
]  # fmt: skip


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


def test_no_python_for_the_floor(tmp_path: Path) -> None:
    (tmp_path / "requirements-floor.txt").touch()
    done = subprocess.run(
        ["make", "-f", ROOT / "Makefile", ".venv-floor/.complete", "FLOOR_PYTHON=python3.1"],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 2
    assert done.stderr.splitlines()[0] == (
        "test-floor: python3.1 is missing; install Python 3.11 or name it: "
        "make test-floor FLOOR_PYTHON=PATH"
    )


def lines(file: Path) -> list[str]:
    """Of a file in which a backslash continues a line, without comments."""
    whole = re.sub(r"\\\n\s*", "", file.read_text()).splitlines()
    return [line for line in whole if not line.startswith("#")]


def locked(name: str) -> dict[str, Requirement]:
    """What a lock file pins here, by name."""
    found = [Requirement(entry.partition("--hash")[0]) for entry in lines(ROOT / name)]
    return {
        canonicalize_name(one.name): one
        for one in found
        if one.marker is None or one.marker.evaluate()
    }


@pytest.mark.parametrize("name", LOCKS)
def test_a_lock_file_pins_all_with_hashes(name: str) -> None:
    for entry in lines(ROOT / name):
        assert re.match(r"[\w.-]+==\S+ .*--hash=sha256:\w{64}", entry), entry


def needs(package: str, extras: frozenset[str] = frozenset()) -> Iterator[Requirement]:
    """What an installed package asks for here, with extras of its own."""
    for line in importlib.metadata.requires(package) or ():
        need = Requirement(line)
        if need.marker is None or any(
            need.marker.evaluate({"extra": extra}) for extra in ("", *extras)
        ):
            yield need


def test_the_lock_file_is_whole() -> None:
    """So it is installed without resolving, and no release of tomorrow can break that."""
    pins = locked("requirements.txt")
    waiting = [(name, frozenset[str]()) for name in pins]
    waiting += [("shoecal_core", frozenset()), ("shoecal_ros", frozenset())]
    done, extras = set(), 0
    while waiting:
        package, wanted = waiting.pop()
        if (package, wanted) in done:
            continue
        done.add((package, wanted))
        for need in needs(package, wanted):
            name = canonicalize_name(need.name)
            if name.startswith("shoecal"):
                continue
            assert name in pins, f"{package} needs {need}, which the lock file lacks"
            (pin,) = pins[name].specifier
            assert need.specifier.contains(Version(pin.version), prereleases=True), (package, need)
            extras += bool(need.extras)
            waiting.append((name, frozenset(need.extras)))
    assert extras, "packages with extras are among what is installed"


class Environment:
    """A virtual environment whose pip and uv write down how they are called."""

    def __init__(self, folder: Path) -> None:
        self.folder, self._log = folder, folder / "calls.txt"
        (folder / "bin").mkdir()
        self.settings = self.uv_code = ""

    def install(self, lock: str) -> list[list[str]]:
        """Install a lock file; the calls that install something."""
        for name, told in {"python": self.settings, "uv": ""}.items():
            program = self.folder / "bin" / name
            code = self.uv_code if name == "uv" else ""
            program.write_text(
                f'#!/bin/sh\necho "{name} $*" >>{self._log}\n'
                f'case "$*" in *config*) echo "{told}" ;; esac\nexit {code or 0}\n'
            )
            program.chmod(0o755)
        subprocess.run([SCRIPTS / "install_lock.sh", self.folder, lock], check=True)
        calls = [line.split() for line in self._log.read_text().splitlines()]
        return [call for call in calls if "install" in call]


@pytest.fixture
def environment(tmp_path: Path) -> Environment:
    return Environment(tmp_path)


def check_nothing_is_resolved(calls: list[list[str]]) -> None:
    for call in calls:
        assert {"--no-deps", "--require-hashes", "--requirement"} <= set(call)


def test_uv_installs_a_lock_file_as_it_is(environment: Environment) -> None:
    environment.settings = "global.extra-index-url='https://example.org'"
    tools, packages = environment.install("a.txt")
    check_nothing_is_resolved([tools, packages])
    assert packages[0] == "uv"
    assert packages[-1] == "a.txt"
    pinned = (environment.folder / "tools.txt").read_text()
    assert re.findall("^[a-z]+(?===)", pinned, re.MULTILINE) == ["setuptools", "uv"]


@pytest.mark.parametrize(
    ("settings", "uv_code"), [("global.index-url='https://example.org'", ""), ("", "1")]
)
def test_where_uv_does_not_do_pip_installs_the_same(
    environment: Environment, settings: str, uv_code: str
) -> None:
    environment.settings, environment.uv_code = settings, uv_code
    calls = environment.install("a.txt")
    check_nothing_is_resolved(calls)
    assert calls[-1][:3] == ["python", "-m", "pip"]
    assert calls[-1][-1] == "a.txt"


def test_nothing_else_installs_packages() -> None:
    for file in (ROOT / "Makefile", *SCRIPTS.glob("*.sh")):
        for line in lines(file):
            if re.search(r"\bpip\b.* install\b", line):
                assert file.name == "install_lock.sh" or "--no-deps" in line, line


def test_a_long_step_says_that_it_goes_on() -> None:
    with subprocess.Popen(
        [SCRIPTS / "still_running.sh", "build", "sh", "-c", "read line; exit 3"],
        env=os.environ | {"EVERY_S": "0.1"}, stdin=subprocess.PIPE, stdout=subprocess.PIPE,
    ) as step:  # fmt: skip
        assert step.stdout is not None
        assert step.stdout.readline().startswith(b"build: still running (")
        step.communicate(b"\n", timeout=60)
    assert step.returncode == 3


def test_a_short_step_ends_when_its_command_does() -> None:
    """What says that it goes on holds neither its output nor the lock of set-up."""
    with subprocess.Popen(
        [SCRIPTS / "still_running.sh", "build", "true"],
        env=os.environ | {"EVERY_S": "1000"}, stdout=subprocess.PIPE,
    ) as done:  # fmt: skip
        out, _ = done.communicate(timeout=60)
    assert (done.returncode, out) == (0, b"")


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
