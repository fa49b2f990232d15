"""The paper's evaluation, small: one robot's shoes by hand, two robots' runs, the page."""

from __future__ import annotations

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from core.report.sessions import swaying_session
from paper import write
from paper_reproduction import Paper, Reproduction, reproduce
from paper_tables import to_json
from paper_targets import missed
from population import ROOT, Member

PAGE = ROOT / "docs" / "evidence" / "paper.md"


class Swaying(Member):
    """Made in a moment: two runs to train, one to test."""

    @property
    def train(self) -> tuple[int, ...]:
        return 1, 2

    @property
    def test(self) -> tuple[int, ...]:
        return (3,)


@pytest.fixture(scope="module")
def robots(tmp_path_factory: pytest.TempPathFactory) -> list[Reproduction]:
    """Their shoes on the rig have other cells than those of the runs: figures come out bad."""
    folder = tmp_path_factory.mktemp("paper")
    found = []
    for seed in (1, 2):
        session = swaying_session(folder / f"seed_{seed}")
        found.append(reproduce(Swaying(seed, seed, session.folder), session))
    return found


def test_manual_calibration_meets_the_papers(robots: list[Reproduction]) -> None:
    for foot, after in zip(robots[0].manual.feet, (1.07, 0.76), strict=True):
        assert foot.grf.mean <= 0.03
        assert 3e-3 <= foot.known_cop.before.mean <= 5e-3
        assert 1e3 * foot.known_cop.after.mean <= after
        assert foot.grf.count == 7 * 18


def test_everything_promised_stands_in_the_json(robots: list[Reproduction]) -> None:
    found = json.loads(json.dumps(to_json(Paper(robots)), allow_nan=False))
    assert found["seeds"] == [1, 2]
    for foot in ("left", "right"):
        assert {"grf_mae_n", "cop_before_mm", "cop_after_mm"} <= found["manual"][foot].keys()
    assert [row["run"] for row in found["assumptions"]] == [1, 2, 3]
    for row in found["assumptions"]:
        assert {"grf_mae_n", "cop_mae_mm"} <= row.keys()
    stages = found["self_calibration"]
    for name in ("initial_guess", "train", "test"):
        assert {"grf_mae_n", "cop_mae_mm"} <= stages[name].keys()
    assert stages["p_value"] == min(stages["p_value_grf"], stages["p_value_cop"])


def test_page_and_figures(robots: list[Reproduction], tmp_path: Path) -> None:
    paper = Paper(robots)
    doc, figures = tmp_path / "docs" / "evidence" / "paper.md", tmp_path / "out" / "paper.json"
    doc.parent.mkdir(parents=True)
    doc.write_text(PAGE.read_text())
    # Cells of another seed read the runs: the assumptions cannot hold, and that is told.
    assert write(paper, figures, doc) == 1
    text = doc.read_text()
    assert re.findall("<!-- .* -->", text) == re.findall("<!-- .* -->", PAGE.read_text())
    assert "modelled CoP, by run" in "".join(missed(paper))
    # The model of these runs is the truth.
    assert "| model | 2 robots | 0.00 ± 0.00 | 0.00 ± 0.00 |" in text
    names = ("manual", "assumptions", "train", "test", "errors")
    for name in names:
        assert f"(../figures/paper-{name}.svg)" in text
        ElementTree.parse(doc.parent.parent / "figures" / f"paper-{name}.svg")
    assert json.loads(figures.read_text())["seed"] == 1
    assert "4.53 ± 1.89" in text
    assert "nan" not in text
