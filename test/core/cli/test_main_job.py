"""simulate, check, calibrate, evaluate: the main job without ROS, on the second robot."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from core.cli.conftest import Run
from shoecal_core import cli
from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.files import read_yaml, sha256
from shoecal_core.report.quantities import size


def test_a_session_is_found_fit_for_use(shoecal: Run, simulated: Path) -> None:
    code, out, _ = shoecal("check", simulated)
    assert code == 0
    assert "fit for use" in out


def test_how_far_it_can_be_trusted(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    again, figures = tmp_path / "again.yaml", tmp_path / "figures.json"
    code, out, error = shoecal(
        "calibrate", simulated, "--train", "1,2,3", "--test", "4", "--out", again, "--json", figures
    )
    assert code == 0, error
    # Solving again gives the same parameters.
    one, other = load_calibration(calibrated).parameters, load_calibration(again).parameters
    np.testing.assert_array_equal(one.gain, other.gain)
    np.testing.assert_array_equal(one.offset, other.offset)
    found = json.loads(figures.read_text())
    told = found["assessment"]
    for foot, label in (("both", "both feet"), ("left", "left foot"), ("right", "right foot")):
        expected = told["expected_error"][foot]
        (line,) = [line for line in out.splitlines() if line.strip().startswith(label)]
        values = re.split(r" {2,}", line.strip().replace("\N{NO-BREAK SPACE}", " "))[1:]
        assert values[0] == size(expected["grf_std_n"], "N").replace("\N{NO-BREAK SPACE}", " ")
        for value, name in ((values[1], "cop_mae_mm"), (values[-1], "cop_worst_mm")):
            assert value == size(expected[name], "mm").replace("\N{NO-BREAK SPACE}", " ")
    assert f"the data identify {told['rank']} of {told['possible_rank']} directions" in out
    for words in told["weak_directions"]:
        assert f"not identified: {words}" in out
    lost = sum(one["samples"] for one in found["screening"]["left_out"])
    assert (
        f"left out before the fit: {lost} of {sum(found['screening']['samples'].values())}" in out
    )
    # Last come the verdict's reasons, each in a line of its own with its level once, the file, and
    # what to do with it.
    assert f"/shoe/set_calibration with {again}" in out.splitlines()[-1]
    last = out.splitlines()[-2 - len(found["reasons"]) : -2]
    assert last == [
        reason if ": " in reason[:6] else f"{found['verdict']}: {reason}"
        for reason in found["reasons"]
    ]


def test_held_out_errors_against_the_truth(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    figures = tmp_path / "errors.json"
    code, _, error = shoecal(
        "evaluate", simulated, "--calibration", calibrated,
        "--train", "1,2,3", "--test", "4", "--json", figures,
    )  # fmt: skip
    assert code == 0, error
    test = json.loads(figures.read_text())["against_truth"]["test"]
    # The paper's figures, on a heavier robot.
    assert test["grf_mae_n"] < 0.35 * 8.66 / 5.48
    assert test["cop_mae_mm"] < 4.2


def test_gains_come_near_the_drawn_ones(simulated: Path, calibrated: Path) -> None:
    drawn = read_yaml(simulated / "truth" / "reality.yaml").mapping("gain")
    found = load_calibration(calibrated)
    true = np.array([drawn.number(name) for name in found.channels])
    np.testing.assert_allclose(found.parameters.gain, true, rtol=0.2)
    assert np.sum(np.sign(true) < 0) == 1  # the inverted cell


def test_a_calibration_knows_the_runs_it_was_fitted_to(simulated: Path, calibrated: Path) -> None:
    fitted = [sha256(simulated / f"run_{run:03d}.mcap") for run in (1, 2, 3)]
    assert load_calibration(calibrated).fitted_runs == tuple(fitted)


def test_one_support_is_refused_with_the_cure(
    shoecal: Run, simulated: Path, tmp_path: Path
) -> None:
    out = tmp_path / "calibration.yaml"
    code, _, error = shoecal("calibrate", simulated, "--train", "1", "--out", out)
    assert code == 1
    assert "record at least 2 that differ in yaw" in " ".join(error.split())
    assert not out.exists()


@pytest.mark.parametrize(
    ("words", "cure"),
    [
        (["--train", "9"], "has no run 9"),
        (["--train", "1,2", "--test", "2"], "a test run is not fitted"),
    ],
)
def test_wrong_runs_are_named(
    shoecal: Run, simulated: Path, tmp_path: Path, words: list[str], cure: str
) -> None:
    code, _, error = shoecal("calibrate", simulated, *words, "--out", tmp_path / "c.yaml")
    assert code == 1
    assert cure in " ".join(error.split())


@pytest.mark.parametrize("named", ["session/run_002.mcap.part", "session"])
def test_a_cut_run_is_named_recovered_and_fit_again(
    shoecal: Run, simulated: Path, tmp_path: Path, named: str
) -> None:
    session = tmp_path / "session"
    shutil.copytree(simulated, session)
    run = session / "run_002.mcap"
    content = run.read_bytes()
    run.unlink()
    part = run.with_name("run_002.mcap.part")
    part.write_bytes(content[: len(content) * 3 // 4])
    code, out, error = shoecal("check", session)
    assert code == 1
    assert "shoecal recover" in out
    assert error.count("\n") == 1
    code, out, _ = shoecal("recover", tmp_path / named)
    assert code == 0
    assert run.exists()
    code, out, error = shoecal("recover", session)
    assert (code, out) == (1, "")
    assert "holds no interrupted run" in error
    part.unlink()
    assert shoecal("check", session)[0] == 0


def test_a_missing_session_is_one_line(shoecal: Run, tmp_path: Path) -> None:
    code, out, error = shoecal("check", tmp_path / "nowhere")
    assert code == 1
    assert not out
    assert error.count("\n") == 1
    assert "nowhere" in error


@pytest.mark.parametrize(
    ("words", "cure"),
    [
        (["plan", "robot.yaml", "--out", "out", "--seed", "-1"], "a whole number, 0 or more"),
        (["calibrate", "session", "--out", "c.yaml", "--train", "1,1"], "name each run once"),
        (["calibrate", "session", "--out", "c.yaml", "--train", ""], "run numbers separated"),
        (["simulate", "r", "s", "--out", "o", "--rate", "0"], "1 to 10000 Hz"),
        (["calibrat"], "invalid choice"),
        (["new", "wren.urdf"], "'wren.urdf': write 'shoecal new robot wren.urdf'"),
    ],
)
def test_wrong_usage_is_one_line(
    capsys: pytest.CaptureFixture[str], words: list[str], cure: str
) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(words)
    assert ended.value.code == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert cure in told


def test_a_calibration_outlives_a_report_that_cannot_be_written(
    shoecal: Run, simulated: Path, tmp_path: Path
) -> None:
    out = tmp_path / "calibration.yaml"
    # As long as names may be: the file that it is first written to has none.
    words = ["--train", "1,2,3", "--test", "4", "--out", out, "--report", tmp_path / ("r" * 255)]
    code, _, error = shoecal("calibrate", simulated, *words)
    assert code == 1
    assert "cannot be written" in error
    assert load_calibration(out).verdict != "FAIL"


def test_a_folder_in_place_of_a_file_is_refused_before_any_work(
    shoecal: Run, simulated: Path, tmp_path: Path
) -> None:
    for option in ("--out", "--report"):
        words = {"--out": tmp_path / "calibration.yaml", option: tmp_path}
        code, out, error = shoecal("calibrate", simulated, *sum(words.items(), ()))
        assert (code, out) == (1, "")
        assert f"{tmp_path}: is a folder; name a file" in error


def test_a_run_that_vanished_is_told(shoecal: Run, simulated: Path, tmp_path: Path) -> None:
    session = tmp_path / "session"
    shutil.copytree(simulated, session)
    (session / "run_003.mcap").unlink()
    code, out, _ = shoecal("check", session)
    assert code == 1
    assert "run 3 was begun but its file is gone" in out
    code, out, _ = shoecal("calibrate", session, "--out", tmp_path / "c.yaml")
    assert code == 0
    assert "WARN: run 3 was begun but its file is gone" in " ".join(out.split())
    for run in session.glob("run_*.mcap"):
        run.unlink()
    gone = "runs 1, 2, 3, 4 were begun but their files are gone: put them back"
    code, out, error = shoecal("check", session)
    assert [line for line in out.splitlines() if line.startswith("FAIL")] == [f"FAIL: {gone}"]
    assert "1 problem(s)" in error
    for words in (("calibrate", session, "--out", tmp_path / "d.yaml"), ("diagnose", session)):
        code, _, error = shoecal(*words)
        assert code == 1
        assert error == f"shoecal {words[0]}: {session}: has no run: {gone}\n"
