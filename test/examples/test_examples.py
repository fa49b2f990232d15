"""The examples, run as a user runs them, against what is known of the simulated robots."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from ros.bodies import nao
from ros.nodes.test_calibrator_node import SUPPORT, set_calibration
from ros.standing_robot import StandingRobot
from ros.world import World
from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.files import read_yaml
from shoecal_core.robot.kinematics import Kinematics
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe

EXAMPLES = Path(__file__).parents[2] / "examples"
LONGEST = 60
"""Lines of an example."""


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where all of them write."""
    return tmp_path_factory.mktemp("out")


@pytest.fixture(scope="module")
def calibrated(out: Path) -> str:
    """What calibrate_session.py says; its session is the others' input."""
    return run("calibrate_session", out)


def run(name: str, out: Path, *words: str | Path) -> str:
    """Run an example, which has to draw a picture; what it prints."""
    command = [sys.executable, EXAMPLES / f"{name}.py", "--out", out, *words]
    done = subprocess.run(
        list(map(str, command)), cwd=out, env=os.environ, capture_output=True, text=True,
        timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    require_picture(out / f"{name}.png")
    return done.stdout


def require_picture(file: Path) -> None:
    """More than white is in it."""
    assert np.ptp(imread(file)[..., :3]) > 0.5


def number(pattern: str, text: str) -> float:
    """The number at the end of a pattern."""
    found = re.search(rf"{pattern}\s*([-+]?\d[\d.e-]*)", text)
    assert found, f"no '{pattern}' in:\n{text}"
    return float(found[1])


def true_gains(session: Path) -> dict[str, float]:
    gains = read_yaml(session / "truth" / "reality.yaml").mapping("gain")
    return {name: gains.number(name) for name in gains.keys()}


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.py")), ids=lambda file: str(file.stem))
def test_examples_are_short(file: Path) -> None:
    assert len(file.read_text().splitlines()) <= LONGEST


def test_calibrate_session(calibrated: str, out: Path) -> None:
    assert "PASS: every check passed" in calibrated
    assert number("initial_guess:", calibrated) > 10.0
    assert number("self_calibration:", calibrated) < 1.5
    found = load_calibration(out / "calibration.yaml")
    for channel, true in true_gains(out / "session").items():
        assert number(channel, calibrated) == pytest.approx(true, rel=0.1)
    assert found.verdict == "PASS"


def test_import_log(calibrated: str, out: Path) -> None:
    for _ in ("imported", "read again"):
        assert "4 runs; PASS" in run("import_log", out, "--session", out / "session")
    found = load_calibration(out / "imported.yaml")
    true = true_gains(out / "session")
    # The log is in mV, and the mapping turns it into V again.
    np.testing.assert_allclose(
        found.parameters.gain, [true[name] for name in found.channels], rtol=0.1
    )


def test_compare_calibrations(calibrated: str, out: Path) -> None:
    said = run("compare_calibrations", out, "--session", out / "session")
    (changed,) = re.findall(r"(\S+) .*  changed", said)
    assert changed == "left/front_left"
    # A reading that is 10 % larger has a gain that is 9.1 % smaller.
    assert number(changed, said) == pytest.approx(-9.1, abs=3.0)
    assert number("new calibration:", said) < number("old calibration:", said)


def test_diagnose_session(out: Path) -> None:
    said = run("diagnose_session", out)
    assert "\nexplained\nnonlinearity (left/front_left), probability " in said
    assert number("probability", said) >= 90
    # The effect and its place are right; the size comes out too small on four slow runs.
    assert 0.006 < number("quadratic", said) < 0.024


def test_own_effect_is_found(out: Path) -> None:
    said = run("own_effect", out)
    assert said.startswith("explained\ntether: stiffness ")
    assert number(r"tether: stiffness [\d.]+ \(", said) < 20.0 < number(r"tether: .* to", said)


def test_own_shoe(out: Path) -> None:
    said = run("own_shoe", out)
    assert "PASS: every check passed" in said
    assert number("median:", said) < 4.0


def test_correct_mjcf(out: Path) -> None:
    said = run("correct_mjcf", out)
    assert number("corrected one:", said) < number("against the model:", said)
    for name in ("robot.yaml", "robot.urdf", "robot.xml", "randomisation.yaml"):
        assert (out / "mjcf" / name).is_file()
    shoe = load_shoe(out / "mjcf" / "my_shoe.yaml")
    # The robot of the simulator has its body's CoM 5 mm further forward than its files say.
    found, drafted = (
        load_robot(out / "mjcf" / name, shoe).model for name in ("robot.yaml", "my.yaml")
    )
    base = [float(model.inertias[1].lever[0]) for model in (found, drafted)]
    assert base[0] - base[1] == pytest.approx(0.005, abs=0.0035)


def test_tutorial_runs(
    calibrated: str, out: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """Its cells in order, in one process and from one folder."""
    monkeypatch.chdir(out)
    monkeypatch.setenv("MPLBACKEND", "agg")
    tutorial = out / "tutorial"
    tutorial.mkdir()
    for name in ("session", "bends"):
        if (out / name).exists():  # of the scripts: the same robot
            (tutorial / name).symlink_to(out / name)
    notebook = json.loads((EXAMPLES / "tutorial.ipynb").read_text())
    names: dict[str, object] = {}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            assert not cell["outputs"]
            exec("".join(cell["source"]), names)  # as Jupyter does
    said = capfd.readouterr().out
    assert "PASS: every check passed" in said
    assert number("against the truth, test:", said) < 4.0
    assert "explained" in said
    assert "nonlinearity (left/front_left)" in said


@pytest.fixture
def live(tmp_path: Path) -> Iterator[tuple[World, StandingRobot]]:
    """A calibrator that publishes the CoP of a robot that stands."""
    with World(tmp_path) as world:
        robot = StandingRobot(world, SUPPORT)
        state = {"state_dir": tmp_path / "state", "sessions_dir": tmp_path / "sessions"}
        world.start("calibrator", {"stale_s": 10.0, **state})
        assert set_calibration(world).success
        yield world, robot


def test_read_cop(live: tuple[World, StandingRobot], out: Path) -> None:
    world, robot = live
    reader = EXAMPLES / "read_cop.py"
    right = Kinematics(nao()).states(robot.angles[None]).support().right_to_left(robot.places[1])
    share = robot.forces[0] / sum(robot.forces)
    expected = 1e3 * (share * robot.places[0] + (1.0 - share) * right)

    world.start("read_cop", {}, "--", "--out", str(out), "--count", "20", script=reader)
    process = world.processes.pop("read_cop")
    world.until(lambda: process.poll() is not None)
    said = world.output("read_cop")
    assert process.returncode == 0, said
    x, y = map(float, re.findall(r"CoP in l_sole: (\S+) (\S+) mm", said)[0])
    assert (x, y) == pytest.approx(expected, abs=0.06)
    require_picture(out / "read_cop.png")

    (out / "read_cop.png").unlink()
    world.start("read_cop", {}, "--", "--out", str(out), "--count", "100000", script=reader)
    world.until_logged("read_cop", "CoP in l_sole")
    assert world.stop("read_cop") == 0, world.output("read_cop")
    require_picture(out / "read_cop.png")
