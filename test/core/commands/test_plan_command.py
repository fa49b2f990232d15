"""plan: motions and what they will tell, of the second robot."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from core.commands.conftest import WREN, WREN_SHOE
from shoecal_core import cli

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("planned")
    words = ["plan", WREN, "--shoe", WREN_SHOE, "--supports", "4", "--out", folder]
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


def test_every_motion_is_drawn_and_all_on_a_page(planned: Path) -> None:
    told = json.loads((planned / "plan.json").read_text())
    assert told["page"] == "plan.html"
    html = (planned / told["page"]).read_text()
    for number, row in enumerate(told["motions"], start=1):
        assert row["file"] == f"motion_{number:03d}.csv"
        assert row["picture"] == f"motion_{number:03d}.svg"
        root = ElementTree.fromstring((planned / row["picture"]).read_text())
        assert f"motion_{number:03d} (landmarks)" in root.attrib["aria-label"]
        duration = float((planned / row["file"]).read_text().splitlines()[-1].split(",")[0])
        assert row["duration_s"] == pytest.approx(duration, abs=1e-3)
        assert f"{duration:.1f} s" in html.replace("\N{NO-BREAK SPACE}", " ")
    assert html.count('<figure class="player">') == len(told["motions"]) == 4
    assert "://" not in html
    assert len(html) < 3_000_000


def test_the_best_to_add_bring_something(planned: Path) -> None:
    told = json.loads((planned / "figures.json").read_text())
    before = told["forecast"]["all"]
    for addition in told["forecast"]["best_additions"]:
        after = addition["forecast"]
        assert min(after["singular_values"]) > min(before["singular_values"])
        assert len(addition["support"]) == 3
        before = after
