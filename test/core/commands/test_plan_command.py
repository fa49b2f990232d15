"""plan: motions and what they will tell, of the second robot."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from core.commands.conftest import ROBOT, SHOE
from shoecal_core import cli

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("planned")
    words = ["plan", ROBOT, "--shoe", SHOE, "--supports", "4", "--out", folder]
    assert cli.main([str(word) for word in (*words, "--json", folder / "figures.json")]) == 0
    return folder


def test_forecast_of_the_planned_double_supports(planned: Path) -> None:
    told = json.loads((planned / "figures.json").read_text())
    assert told["forecast"] == json.loads((planned / "plan.json").read_text())["forecast"]
    whole, part = told["forecast"]["all"], told["forecast"]["worst_training"]
    assert whole["rank"] == part["rank"] == whole["possible_rank"]
    assert len(part["motions"]) == 3
    assert set(part["motions"]) < {1, 2, 3, 4}
    for name, error in whole["expected_error"].items():
        assert 0.0 < error < part["expected_error"][name]
    singular = np.array(whole["singular_values"])
    assert (np.diff(singular) <= 0.0).all()
    assert len(whole["gain_std"]) == len(whole["offset_std_n"])


def test_the_best_to_add_bring_something(planned: Path) -> None:
    told = json.loads((planned / "figures.json").read_text())
    before = told["forecast"]["all"]
    for addition in told["forecast"]["best_additions"]:
        after = addition["forecast"]
        assert min(after["singular_values"]) > min(before["singular_values"])
        assert len(addition["support"]) == 3
        before = after
