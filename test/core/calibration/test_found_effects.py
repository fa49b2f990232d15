"""What `shoecal diagnose --json` wrote, read again."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from shoecal_core.calibration.refinement.found_effects import load_found_effects
from shoecal_core.diagnosis.result import Cause, Diagnosis, Gap, Shrink, Size
from shoecal_core.errors import FileError, VersionError

NOTHING = Shrink(0.5, (0.4, 0.6), (1.0, 0.5), (0.2, 0.1))
CAUSE = Cause(
    effect="cell_position",
    group="load_cell",
    location=("left/front_left",),
    probability=0.9,
    size={"x": Size(0.003, "m", (0.003 - 1.96e-4, 0.003 + 1.96e-4))},
    run=None,
    shrink=NOTHING,
    hidden_cop_mm=0.1,
)
DIAGNOSIS = Diagnosis(
    "explained", Gap(1.0, 0.1, 0.1, 0.01), (), (CAUSE,), (), (), (), (), None, (1, 2), (3,), (),
    "nao", "nao_shoe",
)  # fmt: skip


def written(folder: Path, told: object) -> Path:
    path = folder / "diagnosis.json"
    path.write_text(json.dumps(told))
    return path


def test_a_cause_with_its_interval(tmp_path: Path) -> None:
    found = load_found_effects(written(tmp_path, DIAGNOSIS.to_json()))
    assert (found.robot, found.shoe, found.verdict) == ("nao", "nao_shoe", "explained")
    (effect,) = found.effects
    assert (effect.effect, effect.location) == (CAUSE.effect, CAUSE.location)
    assert effect.label == CAUSE.label
    mean, std = effect.size["x"]
    assert effect.probability == CAUSE.probability
    assert found.sure(effect)
    assert mean == 0.003
    assert std == pytest.approx(1e-4)


@pytest.mark.parametrize("told", [[], {}, {"sessions": []}, "text"])
def test_what_is_no_diagnosis(tmp_path: Path, told: object) -> None:
    with pytest.raises(FileError, match="shoecal diagnose --json"):
        load_found_effects(written(tmp_path, told))


def test_no_json(tmp_path: Path) -> None:
    path = tmp_path / "diagnosis.json"
    path.write_text("causes: []")
    with pytest.raises(FileError, match="is no JSON file"):
        load_found_effects(path)


def test_of_a_newer_version(tmp_path: Path) -> None:
    with pytest.raises(VersionError):
        load_found_effects(written(tmp_path, {**DIAGNOSIS.to_json(), "format": 2}))


def test_an_interval_turned_round(tmp_path: Path) -> None:
    told = json.loads(json.dumps(DIAGNOSIS.to_json()))
    told["causes"][0]["size"]["x"]["ci95"] = [1.0, 0.0]
    with pytest.raises(FileError, match="ci95"):
        load_found_effects(written(tmp_path, told))
