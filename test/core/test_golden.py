"""Three sessions whose calibration and diagnosis stay what they were, number by number.

Whoever changes an estimate on purpose makes the file anew, and shows why in the same commit:

    .venv/bin/python test/core/test_golden.py
"""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from shoecal_core import cli
from shoecal_core.estimation.calibration import load_calibration

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "config"
DATA = ROOT / "test" / "data"
GOLDEN = DATA / "golden.json"
STDS = 0.1
"""A parameter may move by this part of its standard deviation."""
RELATIVE, LEAST = 0.1, 0.005
"""An error or a size may change by this part of itself, or by so many N or mm: rounding in the
planner changes when a motion passes where, and so which samples there are."""


@dataclass(frozen=True)
class Recorded:
    """How a session is simulated, and which of its runs are calibrated."""

    robot: Path
    shoe: Path
    options: tuple[object, ...]
    reality: str
    runs: tuple[str, ...] = ()


SESSIONS = {
    # Another biped: three cells left, six right, one of them inverted.
    "odd": Recorded(
        DATA / "robots" / "odd_biped.yaml",
        DATA / "shoes" / "odd_shoe.yaml",
        ("--supports", "4", "--rate", "50", "--seed", "6"),
        "format: 1\n",
        ("--train", "1,2,3", "--test", "4"),
    ),
    "wren": Recorded(
        CONFIG / "robots" / "wren.yaml",
        CONFIG / "shoes" / "wren_shoe.yaml",
        ("--motions", "thorough", "--rate", "50", "--seed", "3"),
        (CONFIG / "realities" / "other_laws.yaml").read_text(),
    ),
    "nao": Recorded(
        CONFIG / "robots" / "nao.yaml",
        CONFIG / "shoes" / "nao_shoe.yaml",
        ("--motions", "thorough", "--rate", "50", "--seed", "5"),
        "format: 1\neffects:\n"
        "  - {effect: span_drift, location: [left], rate_per_s: 0.0004}\n"
        "  - {effect: joint_offset, location: [RAnkleRoll], angle_rad: 0.02}\n",
    ),
}


def shoecal(*words: object) -> None:
    assert cli.main([str(word) for word in words]) == 0


def measured(recorded: Recorded, folder: Path) -> dict[str, Any]:
    """What a calibration and a diagnosis of that session say, as in the file."""
    session, reality = folder / "session", folder / "reality.yaml"
    stored, figures, told = (folder / name for name in ("c.yaml", "c.json", "d.json"))
    reality.write_text(recorded.reality)
    shoecal(
        "simulate", recorded.robot, recorded.shoe, "--reality", reality, *recorded.options,
        "--out", session,
    )  # fmt: skip
    shoecal("calibrate", session, *recorded.runs, "--out", stored, "--json", figures)
    shoecal("diagnose", session, *recorded.runs, "--no-simulation", "--json", told)
    calibration = load_calibration(stored)
    parameters = calibration.parameters
    assert calibration.covariance is not None
    stds = np.sqrt(np.diag(calibration.covariance))
    calibrated, diagnosed = json.loads(figures.read_text()), json.loads(told.read_text())
    return {
        "vector": np.concatenate([parameters.gain, parameters.offset]).tolist(),
        "stds": stds.tolist(),
        "verdict": calibrated["verdict"],
        "errors": {
            part: {key: value for key, value in found.items() if "samples" not in key}
            for part, found in calibrated["against_model"]["self_calibration"].items()
        },
        "time_offset_s": calibration.time_offset,
        "diagnosis": {
            "verdict": diagnosed["verdict"],
            "gap": diagnosed["gap"],
            "causes": [
                {key: cause[key] for key in ("effect", "location", "size")}
                for cause in diagnosed["causes"]
            ],
        },
    }


@pytest.mark.parametrize("name", SESSIONS)
def test_estimates_stay(name: str, tmp_path: Path) -> None:
    before = json.loads(GOLDEN.read_text())[name]
    now = measured(SESSIONS[name], tmp_path)
    moved = np.subtract(now.pop("vector"), before.pop("vector")) / before["stds"]
    assert np.max(np.abs(moved)) < STDS, moved
    assert_close(now, before)


def assert_close(now: Any, before: Any) -> None:
    """The same keys and words; numbers but for a small part of themselves."""
    if isinstance(before, dict):
        assert now.keys() == before.keys()
        for key in before:
            assert_close(now[key], before[key])
    elif isinstance(before, list):
        assert len(now) == len(before)
        for one, other in zip(now, before, strict=True):
            assert_close(one, other)
    elif isinstance(before, float):
        assert now == pytest.approx(before, rel=RELATIVE, abs=LEAST)
    else:
        assert now == before


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        found = {}
        for session, recorded in SESSIONS.items():
            place = Path(scratch) / session
            place.mkdir()
            found[session] = measured(recorded, place)
    GOLDEN.write_text(json.dumps(found, indent=1) + "\n")
