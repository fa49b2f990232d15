"""The second robot does the whole job from its files alone: simulated, calibrated, evaluated."""

from __future__ import annotations

import json
from pathlib import Path

from core.cli.conftest import WREN, WREN_SHOE, Run


def test_from_two_files_to_a_calibration(tmp_path: Path, shoecal: Run) -> None:
    session, calibration = tmp_path / "session", tmp_path / "calibration.yaml"
    figures = tmp_path / "figures.json"
    words = ("--supports", "3", "--rate", "50", "--out", session)
    code, _, error = shoecal("simulate", WREN, WREN_SHOE, *words)
    assert code == 0, error
    code, told, error = shoecal("calibrate", session, "--out", calibration, "--json", figures)
    assert code == 0, error
    assert "the data identify 12 of 12 directions" in told
    fitted = json.loads(figures.read_text())
    assert fitted["verdict"] == "PASS", fitted["reasons"]
