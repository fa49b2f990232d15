"""`shoecal evaluate` with a reference, over several sessions, and with what does not fit."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from core.cli.conftest import Run
from core.estimation import synthetic
from core.report.sessions import swaying_session
from shoecal_core.estimation.calibration import Calibration, save_calibration
from shoecal_core.files import sha256
from shoecal_core.recording.session import Session
from shoecal_core.shoe.wrench import ChannelParameters


@pytest.fixture(scope="module")
def swaying(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of three runs in which the model is the truth."""
    return swaying_session(tmp_path_factory.mktemp("swaying") / "session").folder


@pytest.fixture(scope="module")
def true_calibration(swaying: Path) -> Calibration:
    """The parameters it was made with, as the best calibration would find them."""
    session = Session.open(swaying)
    return Calibration(
        id="manual-1", source="manual", made_ns=1, robot=session.robot, shoe=session.shoe.name,
        robot_hash="", shoe_hash=session.shoe.digest, channels=session.shoe.names,
        parameters=synthetic.truth(session.shoe, np.random.default_rng(3)), covariance=None,
        corrections=(), weight=50.0, time_offset=0.0, temperature=float("nan"), verdict="PASS",
        reasons=(),
    )  # fmt: skip


@pytest.fixture(scope="module")
def reference(true_calibration: Calibration, swaying: Path) -> Path:
    path = swaying.with_name("reference.yaml")
    save_calibration(true_calibration, path)
    return path


@pytest.fixture(scope="module")
def fitted(true_calibration: Calibration, swaying: Path) -> Path:
    """One that says it was fitted to runs 1 and 2; its gains are 1 % off."""
    parameters = true_calibration.parameters
    path = swaying.with_name("fitted.yaml")
    digests = tuple(sha256(swaying / f"run_{run:03d}.mcap") for run in (1, 2))
    save_calibration(
        replace(
            true_calibration,
            id="self-1",
            source="self",
            parameters=ChannelParameters(1.01 * parameters.gain, parameters.offset),
            fitted_runs=digests,
        ),
        path,
    )
    return path


@pytest.fixture(scope="module")
def again(swaying: Path) -> Path:
    """Another session, of the third run alone."""
    folder = swaying.with_name("again")
    shutil.copytree(swaying, folder)
    for run in (1, 2):
        (folder / f"run_{run:03d}.mcap").unlink()
    return folder


def test_against_reference_model_and_truth(
    shoecal: Run, swaying: Path, fitted: Path, reference: Path, tmp_path: Path
) -> None:
    figures = tmp_path / "errors.json"
    code, out, error = shoecal(
        "evaluate", swaying, "--calibration", fitted, "--reference", reference,
        "--json", figures,
    )  # fmt: skip
    assert code == 0, error
    found: dict[str, Any] = json.loads(figures.read_text())
    for name in ("modelled", "reference", "truth"):
        assert {"train", "test"} == set(found[f"against_{name}"])
    # 1 % too much of what the cells carry, on each foot and on both together.
    test = found["against_reference"]["test"]
    assert test["left_grf_mae_n"] + test["right_grf_mae_n"] == pytest.approx(test["grf_mae_n"])
    assert 0.4 < test["grf_mae_n"] < 0.6
    assert test["grf_samples"] == 120
    assert {"against_reference", "against_truth"} == set(found["model"])
    assert found["reference"]["against_truth"]["test"]["grf_mae_n"] < 1e-6
    assert [(one["run"], one["set"]) for one in found["runs"]] == [
        (1, "train"), (2, "train"), (3, "test"),
    ]  # fmt: skip
    assert "grf_mae_n" in found["runs"][0]["model"]["against_reference"]
    assert "left foot" in out


def test_several_sessions_with_one_calibration(
    shoecal: Run, swaying: Path, again: Path, fitted: Path, tmp_path: Path
) -> None:
    figures = tmp_path / "errors.json"
    code, out, error = shoecal(
        "evaluate", swaying, again, "--calibration", fitted, "--json", figures
    )
    assert code == 0, error
    found: dict[str, Any] = json.loads(figures.read_text())
    assert [Path(one["session"]).name for one in found["runs"]] == 3 * ["session"] + ["again"]
    assert "again, run 3, test" in out


def refused(shoecal: Run, *words: object) -> str:
    code, out, error = shoecal("evaluate", *words)
    assert code == 1
    assert not out
    assert error.count("\n") == 1
    return " ".join(error.split())


def test_what_does_not_fit_together_is_one_line(
    shoecal: Run,
    swaying: Path,
    fitted: Path,
    true_calibration: Calibration,
    tmp_path: Path,
) -> None:
    given = ["--calibration", fitted]
    boot = tmp_path / "boot.yaml"
    save_calibration(replace(true_calibration, shoe="boot"), boot)
    told = refused(shoecal, swaying, *given, "--reference", boot)
    assert f"{boot}: is of shoe 'boot', but session {swaying} was recorded on" in told
    assert "name each session once" in refused(shoecal, swaying, swaying, *given)
    told = refused(shoecal, swaying, *given, *given)
    assert "--calibration was given 2 times for 1 session(s)" in told
    assert "was fitted to run(s) 1" in refused(shoecal, swaying, *given, "--test", "1")
