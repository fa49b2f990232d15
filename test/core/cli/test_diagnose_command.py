"""`shoecal diagnose`: one session, many, and what it refuses."""

from __future__ import annotations

import importlib.util
import json
from pathlib import Path
from typing import Any

import pytest

from core.cli.conftest import Run
from shoecal_core.cli import diagnose_command, many_sessions
from shoecal_core.cli.diagnose_command import effect_at
from shoecal_core.cli.parsers import command_line
from shoecal_core.diagnosis.result import VERDICT_TEXTS
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation import session_data
from shoecal_core.files import atomic_write
from shoecal_core.recording.run import Run as RecordedRun
from shoecal_core.recording.session import Session
from shoecal_core.samples.aligned import Aligned, align
from shoecal_core.settings import describe

KEYS = {
    "format", "verdict", "gap", "where", "causes", "ambiguity_set", "cannot_detect", "next_motion",
}  # fmt: skip


def test_one_session(shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path) -> None:
    report, figures = tmp_path / "report.html", tmp_path / "figures.json"
    code, out, error = shoecal(
        "diagnose", simulated, "--train", "1,2", "--test", "3", "--calibration", calibrated,
        "--report", report, "--json", figures, "--only", "cell_position", "payload",
    )  # fmt: skip
    assert code == 0, error
    told = json.loads(figures.read_text())
    assert told.keys() >= KEYS
    assert told["verdict"] in VERDICT_TEXTS
    assert told["test"] == [3]
    assert {cause["effect"] for cause in told["causes"]} <= {"cell_position", "payload"}
    assert told["calibration"]["cop_mae_mm"] > 0.0
    assert told["verdict"] in out
    assert "under calibration" in out
    assert report.read_text().startswith("<!DOCTYPE html>")


def test_every_run_is_read_and_aligned_once(
    shoecal: Run, simulated: Path, calibrated: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For the answer, its notes, the calibration's gap and the simulation of what was found."""
    read, aligned = [], []

    def counted(run: RecordedRun, *rest: Any, **more: Any) -> Aligned:
        aligned.append(run.info.run)
        return align(run, *rest, **more)

    def counting(session: Session, number: int) -> RecordedRun:
        read.append(number)
        return reading(session, number)

    reading = Session.read
    monkeypatch.setattr(session_data, "align", counted)
    monkeypatch.setattr(Session, "read", counting)
    code, _, error = shoecal(
        "diagnose", simulated, "--train", "1,2", "--test", "3", "--calibration", calibrated,
        "--only", "cell_position",
    )  # fmt: skip
    assert code == 0, error
    assert read[:3] == aligned == [1, 2, 3]
    # What is replayed in other processes is read there.
    assert set(read) == {1, 2, 3}


def test_many_sessions_one_of_which_fails(
    shoecal: Run, simulated: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figures = tmp_path / "figures.json"
    written: list[dict[str, list[object]]] = []

    def write(path: Path, content: bytes | str) -> None:
        written.append(json.loads(content))
        atomic_write(path, content)

    monkeypatch.setattr(many_sessions, "atomic_write", write)
    missing = tmp_path / "nothing"
    code, out, error = shoecal(
        "diagnose", simulated, missing, "--jobs", "2", "--no-simulation", "--json", figures,
        "--only", "payload", "--train", "1,2", "--test", "3",
    )  # fmt: skip
    assert code == 1
    first, second = json.loads(figures.read_text())["sessions"]
    # What was done is there before the rest is.
    assert [len(one["sessions"]) for one in written] == [1, 2]
    assert written[0]["waiting"] == [str(simulated)]
    assert "waiting" not in written[1]
    assert first["verdict"] in VERDICT_TEXTS
    assert "does not exist" in second["error"]
    assert "1 of 2 sessions failed" in error
    assert "failed" in out


@pytest.mark.parametrize(
    ("words", "problem"),
    [
        (("--effects-from", "none.py"), "none.py"),
        (("--train", "1,2", "--test", "2"), "run(s) [2] are in both"),
        (("--calibration", "none.yaml"), "none.yaml"),
        (
            ("--report", "no/folder/report.html"),
            "no/folder: does not exist; make it first, for",
        ),
    ],
)
def test_what_it_refuses(
    shoecal: Run, simulated: Path, words: tuple[str, ...], problem: str
) -> None:
    code, _, error = shoecal("diagnose", simulated, *words)
    assert code == 1
    assert problem in error
    assert "Traceback" not in error


def gap_of(shoecal: Run, session: Path, figures: Path, *words: str | Path) -> dict[str, float]:
    """The gap that a diagnosis with these words states."""
    code, _, error = shoecal(
        "diagnose", session, *words, "--only", "payload", "--train", "1,2", "--test", "3",
        "--no-simulation", "--json", figures,
    )  # fmt: skip
    assert code == 0, error
    gap: dict[str, float] = json.loads(figures.read_text())["gap"]
    return gap


def test_settings_and_tolerances_of_a_file(shoecal: Run, simulated: Path, tmp_path: Path) -> None:
    """A robot that has nothing wrong as built shows no more than its noise."""
    exact = tmp_path / "exact.yaml"
    none = ", ".join(f"{entry.name}: 0.0" for entry in describe(Tolerances))
    sections = f"diagnosis: {{rate_hz: 2.0}}, tolerances: {{{none}}}"
    exact.write_text(f"/**/calibrator: {{ros__parameters: {{{sections}}}}}")
    usual = gap_of(shoecal, simulated, tmp_path / "usual.json")
    strict = gap_of(shoecal, simulated, tmp_path / "strict.json", "--settings", exact)
    assert strict["cop_floor_mm"] < 0.5 * usual["cop_floor_mm"]


def test_a_weight_of_the_scale(shoecal: Run, simulated: Path, tmp_path: Path) -> None:
    """Nothing but its weight says what GRF a robot should show."""
    usual = gap_of(shoecal, simulated, tmp_path / "usual.json")
    words = ("--weight-kg", "9.0", "--rezero")
    weighed = gap_of(shoecal, simulated, tmp_path / "weighed.json", *words)
    assert weighed["grf_mae_n"] != usual["grf_mae_n"]


def test_the_gap_of_a_calibration_is_against_the_weight_that_was_given(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    figures, weight = tmp_path / "figures.json", 9.81
    gaps = []
    for kg in (None, 9.0):
        words = [] if kg is None else ["--weight-kg", str(kg)]
        code, _, error = shoecal(
            "diagnose", simulated, *words, "--calibration", calibrated, "--only", "payload",
            "--train", "1,2", "--test", "3", "--no-simulation", "--json", figures,
        )  # fmt: skip
        assert code == 0, error
        gaps.append(json.loads(figures.read_text())["calibration"]["grf_mae_n"])
    usual, weighed = gaps
    assert usual < 1.0
    assert abs(weighed - usual) > 0.1 * weight


@pytest.mark.parametrize("section", ["diagnosis", "tolerances", "calibration"])
def test_settings_that_it_does_not_know(
    shoecal: Run, simulated: Path, tmp_path: Path, section: str
) -> None:
    file = tmp_path / "wrong.yaml"
    file.write_text(f"/**/calibrator: {{ros__parameters: {{{section}: {{crostalk: 1.0}}}}}}")
    code, _, error = shoecal("diagnose", simulated, "--settings", file)
    assert code == 1
    assert "wrong.yaml" in error
    assert "crostalk" in error


def test_a_calibration_of_another_robot(
    shoecal: Run, simulated: Path, calibrated: Path, tmp_path: Path
) -> None:
    other = tmp_path / "other.yaml"
    other.write_text(calibrated.read_text().replace("robot: odd_biped", "robot: somebody"))
    code, _, error = shoecal("diagnose", simulated, "--calibration", other)
    assert code == 1
    assert "is of robot 'somebody'" in error


def test_a_session_named_twice(shoecal: Run, simulated: Path) -> None:
    code, _, error = shoecal("diagnose", simulated, simulated)
    assert code == 1
    assert "named twice" in error


@pytest.mark.parametrize("text", ["", ":left", "latency:", "latency:,"])
def test_no_effect(shoecal: Run, simulated: Path, text: str) -> None:
    with pytest.raises(SystemExit) as ended:
        shoecal("diagnose", simulated, "--only", text)
    assert ended.value.code == 2


def test_an_effect_that_there_is_not(shoecal: Run, simulated: Path) -> None:
    code, _, error = shoecal("diagnose", simulated, "--only", "latencies")
    assert code == 1
    assert "no effect named 'latencies' (did you mean 'latency'? there are: nonlinearity, " in error


def test_an_effect_and_its_places() -> None:
    assert effect_at("latency") == ("latency", ())
    assert effect_at("crosstalk:left/a,left/b") == ("crosstalk", ("left/a", "left/b"))


def test_workers_elsewhere_get_whole_paths(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["diagnose", "a", "b", "--scheduler", "tcp://127.0.0.1:1", "--report", "r.html"]
    words += ["--calibration", "c.yaml", "--effects-from", "e.py"]
    jobs = diagnose_command.requests(command_line(["diagnose"]).parse_args(words))
    assert [job.session for job in jobs] == [tmp_path / "a", tmp_path / "b"]
    assert [job.report for job in jobs] == [tmp_path / "r_a.html", tmp_path / "r_b.html"]
    assert {job.calibration for job in jobs} == {tmp_path / "c.yaml"}
    assert {job.effects_from for job in jobs} == {tmp_path / "e.py"}


def test_over_a_cluster(shoecal: Run, simulated: Path, tmp_path: Path) -> None:
    distributed = pytest.importorskip("distributed")
    figures = tmp_path / "figures.json"
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, dashboard_address=None
    ) as cluster:
        code, _, error = shoecal(
            "diagnose", simulated, "--scheduler", cluster.scheduler_address, "--no-simulation",
            "--only", "payload", "--train", "1,2", "--test", "3", "--json", figures,
        )  # fmt: skip
    assert code == 0, error
    (told,) = json.loads(figures.read_text())["sessions"]
    assert told["verdict"] in VERDICT_TEXTS


@pytest.mark.skipif(importlib.util.find_spec("distributed") is not None, reason="Dask is there")
def test_without_dask_it_says_how_to_get_it(shoecal: Run, simulated: Path) -> None:
    code, _, error = shoecal("diagnose", simulated, "--scheduler", "tcp://127.0.0.1:1")
    assert code == 1
    assert "pip install distributed" in error
