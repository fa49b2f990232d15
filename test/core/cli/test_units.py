"""A session of six-axis sensors whose readings are in other units, through the commands."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.cli.conftest import Run as Command
from core.cli.test_faulty_sessions import plain, rewritten
from shoecal_core import cli
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session

ROBOT = Path(__file__).resolve().parents[3] / "config" / "robots" / "nao.yaml"
AXES = ("fx", "fy", "fz", "mx", "my")
FOOT = {
    "plates": {
        "mass_above_kg": 0.05, "com_above_m": [0.02, 0.0, 0.015],
        "mass_below_kg": 0.05, "com_below_m": [0.02, 0.0, 0.005],
    },
    "six_axis": {
        "origin_m": [0.02, 0.0, 0.01],
        "axes": [{"axis": axis, "polarity": 1, "nominal_gain": 1.0} for axis in AXES],
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def six_axis(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A simulated session of two runs."""
    folder = tmp_path_factory.mktemp("six_axis")
    shoe = {
        "format": 1, "name": "six", "unit": "N", "height_m": 0.02,
        "converter": {"lowest": -5000.0, "highest": 5000.0}, "feet": {"left": FOOT, "right": FOOT},
    }  # fmt: skip
    (folder / "six.yaml").write_text(json.dumps(shoe))
    words = ["simulate", ROBOT, folder / "six.yaml", "--motions", "landmarks,reversed"]
    words += ["--seed", "5", "--rate", "50"]
    assert cli.main([str(word) for word in (*words, "--out", folder / "session")]) == 0
    return folder / "session"


@pytest.mark.parametrize(
    ("force", "moment", "told"),
    [
        (1.0, 1e3, ["moments look like N mm (", "the nominal_gain of all moments by 0.001 in"]),
        (1e-3, 1.0, ["forces look like kN (", "the nominal_gain of all forces by 1000 in"]),
        (1.0 / 9.80665, 1.0, ["forces look like kgf or kg (", "of all forces by 9.80665 in"]),
        (1.0, 1.0, []),
    ],
)
def test_the_unit_is_named_with_its_cure(
    shoecal: Command, six_axis: Path, tmp_path: Path, force: float, moment: float, told: list[str]
) -> None:
    names = Session.open(six_axis).shoe.names
    scale = np.array([moment if name.split("/")[1][0] == "m" else force for name in names])

    def scaled(run: Run) -> Run:
        return replace(run, readings=replace(run.readings, value=run.readings.value * scale))

    session = rewritten(six_axis, tmp_path / "s", scaled)
    for words in (("check", session), ("calibrate", session, "--out", tmp_path / "c.yaml")):
        code, out, error = shoecal(*words)
        found = plain(out + error)
        assert all(one in found for one in told)
        if told:
            assert code == 1
            assert "saturated" not in found
            assert "contradict" not in found
        else:
            assert "look like" not in found
