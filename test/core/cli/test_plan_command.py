"""plan: motions and what they will tell, of the second robot."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

from core.cli.conftest import WREN, WREN_SHOE, Run
from core.shoe import mutations
from shoecal_core import cli
from shoecal_core.robot.robot_file import shoe_file_of


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """A configuration of its own: wren and its shoe."""
    for file in (WREN, WREN.with_suffix(".urdf"), WREN_SHOE):
        folder = tmp_path / "config" / file.parent.name
        folder.mkdir(parents=True, exist_ok=True)
        shutil.copy(file, folder)
    return tmp_path / "config"


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("planned")
    words = ["plan", WREN, "--supports", "4", "--out", folder]
    assert cli.main([str(word) for word in (*words, "--json", folder / "figures.json")]) == 0
    return folder


def test_what_the_planned_double_supports_would_fix_is_told(planned: Path) -> None:
    told = json.loads((planned / "figures.json").read_text())
    assert told["forecast"] == json.loads((planned / "plan.json").read_text())["forecast"]
    whole = told["forecast"]["all"]
    assert whole["rank"] == whole["possible_rank"] > 0
    assert whole["weak_directions"] == []
    assert (np.diff(whole["singular_values"]) <= 0.0).all()


def test_the_shoe_is_told(planned: Path) -> None:
    told = json.loads((planned / "plan.json").read_text())
    assert told["shoe"] == "wren_shoe"
    assert told["unplanned"] == []


def test_the_shoe_that_belongs_to_a_robot(
    config: Path, shoecal: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert shoe_file_of(WREN) == WREN_SHOE
    monkeypatch.chdir(config / "robots")
    assert shoe_file_of(Path("wren.yaml")) == Path("../shoes/wren_shoe.yaml")
    (config / "shoes" / "wren_shoe.yaml").rename(config / "shoes" / "boot.yaml")
    code, told, error = shoecal("plan", "wren.yaml", "--out", config / "out")
    assert (code, told) == (1, "")
    (line,) = error.splitlines()
    assert "../shoes/wren_shoe.yaml: does not exist" in line
    assert "wren.yaml; name one (--shoe" in line
    _, _, error = shoecal("plan", "dodo.yaml", "--out", config / "out")
    assert "dodo.yaml: " in error
    assert "shoes" not in error


def test_one_that_cannot_be_planned_is_told_and_the_others_are_planned(
    config: Path, shoecal: Run
) -> None:
    """The neutral stance is far out of reach; the widest one is where the robot can stand."""
    span = yaml.safe_load(WREN.read_text())["support_range"]
    span["dy_m"].update(lower=-0.39, upper=-0.09, neutral=-0.39, step=0.03)
    robot = config / "robots" / "wren.yaml"
    mutations.write_edited(robot, WREN, (("support_range",), span))
    out, figures = config / "out", config / "figures.json"
    words = ("--stance", "neutral", "wide", "--out", out, "--json", figures)
    code, told, error = shoecal("plan", robot, *words)
    assert code == 1
    assert f"{robot} with {config / 'shoes' / 'wren_shoe.yaml'}" in told
    assert "1 of 2 double supports could not be planned" in error.splitlines()[-1]
    plan = json.loads((out / "plan.json").read_text())
    for_programs = json.loads(figures.read_text())
    why = for_programs.pop("error")
    assert (why["code"], plan) == ("partial", for_programs)
    assert why["message"] in error
    (missing,), (row,) = plan["unplanned"], plan["motions"]
    assert missing["label"] == "motion_001"
    assert missing["support"] == [0.0, -0.39, 0.0]
    assert "cannot stand" in missing["reason"]
    assert f"motion_001: not planned: {missing['reason']}" in told
    assert row["file"] == "motion_002.csv"
    assert plan["forecast"]["all"]["rank"] > 0
    names = {file.name for file in out.iterdir()}
    assert names == {"motion_002.csv", "motion_002.svg", "plan.html", "plan.json"}
    page = (out / "plan.html").read_text()
    assert "1 of 2 motions could not be planned" in page
    assert "cannot stand" in page
    code, _, error = shoecal("plan", robot, "--stance", "neutral", "--out", out)
    assert code == 1
    assert "1 of 1 double supports" in error
    assert {file.name for file in out.iterdir()} == {"plan.json"}


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
    assert html.count('<figure class="player" hidden>') == len(told["motions"]) == 4
    assert "://" not in html
    assert len(html) < 3_000_000
