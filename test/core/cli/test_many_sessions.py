"""`check`, `calibrate` and `evaluate` of several sessions; `diagnose` has tests of its own."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from core.cli.conftest import Run
from shoecal_core.cli import many_sessions
from shoecal_core.cli.parsers import command_line
from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.files import atomic_write
from shoecal_core.workflows.many_jobs import ENDED

SETS = ("--train", "1,2,3", "--test", "4")


@pytest.fixture(scope="module")
def unfit(simulated: Path) -> Path:
    """A session of which one run was cut."""
    folder = simulated.with_name("unfit")
    shutil.copytree(simulated, folder)
    (folder / "run_002.mcap").write_bytes((folder / "run_002.mcap").read_bytes()[:20000])
    return folder


def told(figures: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(figures.read_text())
    return found


def test_check_of_several_is_that_of_each(
    shoecal: Run,
    simulated: Path,
    unfit: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    figures, alone, report = (tmp_path / name for name in ("all.json", "one.json", "report.html"))
    written: list[dict[str, list[object]]] = []

    def write(path: Path, content: bytes | str) -> None:
        written.append(json.loads(content))
        atomic_write(path, content)

    monkeypatch.setattr(many_sessions, "atomic_write", write)
    # Names that are short enough for a line of a table.
    monkeypatch.chdir(simulated.parent)
    names = [simulated.name, unfit.name, "nothing"]
    code, out, error = shoecal(
        "check", *names, "--jobs", "2", "--json", figures, "--report", report
    )
    assert code == 1
    fit, damaged, missing = told(figures)["sessions"]
    # What was done is there before the rest is.
    assert [len(one["sessions"]) for one in written] == [1, 2, 3]
    assert [len(one.get("waiting", [])) for one in written] == [2, 1, 0]
    assert "2 of 3 sessions failed" in error
    assert "run_002.mcap: cut, unfinished or damaged" in error
    assert "nothing: does not exist" in " ".join(missing["error"].split())
    assert damaged["problems"]
    for name, verdict in zip(names, ("PASS", "FAIL", "failed"), strict=True):
        *_, line = (line for line in out.splitlines() if line.strip().startswith(name))
        assert verdict in line
    assert (tmp_path / "report_session.html").exists()
    assert (tmp_path / "report_unfit.html").exists()
    assert shoecal("check", simulated.name, "--json", alone)[0] == 0
    assert {"session": simulated.name, **told(alone)} == fit


def test_calibrations_of_several_are_those_of_each(
    shoecal: Run, simulated: Path, calibrated: Path, unfit: Path, tmp_path: Path
) -> None:
    figures = tmp_path / "figures.json"
    code, out, error = shoecal(
        "calibrate", simulated, unfit, *SETS, "--out", tmp_path / "calibration.yaml",
        "--json", figures, "--jobs", "2",
    )  # fmt: skip
    assert code == 1
    assert "1 of 2 sessions failed" in error
    one = tmp_path / "calibration_session.yaml"
    assert load_calibration(one).id == load_calibration(calibrated).id
    assert str(one) in out
    assert not (tmp_path / "calibration_unfit.yaml").exists()
    first, second = told(figures)["sessions"]
    assert first == {"session": str(simulated), **told(calibrated.with_suffix(".json"))}
    assert "run_002.mcap" in second["error"]


def test_one_that_cannot_be_evaluated_does_not_stop_the_others(
    shoecal: Run, simulated: Path, calibrated: Path, unfit: Path, tmp_path: Path
) -> None:
    figures, alone = tmp_path / "figures.json", tmp_path / "alone.json"
    words = ["--calibration", calibrated, *SETS]
    code, out, error = shoecal("evaluate", simulated, unfit, *words, "--json", figures)
    assert code == 1
    assert "1 of 2 sessions failed" in error
    assert "test, truth" in out
    assert shoecal("evaluate", simulated, *words, "--json", alone)[0] == 0
    found, one = told(figures), told(alone)
    assert found["sessions"][0] == {"session": str(simulated), **one}
    assert "run_002.mcap" in found["sessions"][1]["error"]
    # Those that could be are judged together.
    assert {key: found[key] for key in one} == one


@pytest.mark.parametrize("command", ["check", "calibrate", "evaluate", "diagnose"])
def test_a_session_named_twice(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path, command: str
) -> None:
    more = {"calibrate": ["--out", tmp_path / "c.yaml"], "evaluate": ["--calibration", calibrated]}
    code, out, error = shoecal(command, simulated, simulated, *more.get(command, []))
    assert code == 1
    assert not out
    assert "name each session once" in error


def refused(shoecal: Run, *words: object) -> str:
    """The one line of an error, before any work."""
    code, out, error = shoecal(*words)
    assert code == 1
    assert not out
    (line,) = error.splitlines()
    return line


def test_files_that_would_be_written_twice(
    shoecal: Run, simulated: Path, unfit: Path, tmp_path: Path
) -> None:
    namesake, out = tmp_path / simulated.name, tmp_path / "c.yaml"
    shutil.copytree(simulated, namesake)
    line = refused(shoecal, "calibrate", simulated, namesake, "--out", out)
    assert f"--out: {tmp_path / 'c_session.yaml'}, for session {namesake}" in line
    assert "give session folders names that differ" in line
    words = ["calibrate", simulated, unfit, "--out", out]
    line = refused(shoecal, *words, "--report", out)
    assert "each option a file of its own" in line
    line = refused(shoecal, *words, "--json", tmp_path / "c_unfit.yaml")
    assert f"--out: {tmp_path / 'c_unfit.yaml'}, for session {unfit}, would be" in line
    line = refused(shoecal, *words, "--manual", out, "--manual", out, "--manual", out)
    assert "--manual was given 3 times for 2 session(s)" in line
    line = refused(shoecal, "check", simulated, unfit, "--report", tmp_path / "no" / "r.html")
    assert "does not exist; make it first" in line


def test_a_process_that_ends_has_its_session_told_of() -> None:
    job = many_sessions.SessionJob(Path("a"), lambda _: many_sessions.Figures({}))
    assert many_sessions._lost(job).to_json() == {"session": "a", "error": f"a: {ENDED}"}


def test_workers_elsewhere_get_whole_paths(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["calibrate", "a", "b", "--scheduler", "tcp://127.0.0.1:1", "--out", "c.yaml"]
    args = command_line(["calibrate"]).parse_args([*words, "--manual", "m.yaml"])
    assert many_sessions.named_sessions(args) == [tmp_path / "a", tmp_path / "b"]
    assert many_sessions.output_files(args, "out", "report") == [
        {"out": tmp_path / "c_a.yaml"}, {"out": tmp_path / "c_b.yaml"},
    ]  # fmt: skip
    assert many_sessions.one_a_session(args, "--manual", args.manual) == 2 * [tmp_path / "m.yaml"]


def test_over_a_cluster(
    shoecal: Run, simulated: Path, calibrated: Path, unfit: Path, tmp_path: Path
) -> None:
    distributed = pytest.importorskip("distributed")
    figures, out = tmp_path / "figures.json", tmp_path / "c.yaml"
    commands: dict[str, list[object]] = {
        "check": [],
        "calibrate": [*SETS, "--out", out],
        "evaluate": [*SETS, "--calibration", calibrated],
    }
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        for command, words in commands.items():
            spread = ["--scheduler", cluster.scheduler_address, "--json", figures]
            code, _, error = shoecal(command, simulated, unfit, *words, *spread)
            assert code == 1
            assert "1 of 2 sessions failed" in error
            assert "run_002.mcap" in error
            first, second = told(figures)["sessions"]
            assert "error" in second
            assert "error" not in first
    assert load_calibration(tmp_path / "c_session.yaml").id == load_calibration(calibrated).id
