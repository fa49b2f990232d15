"""The report of a manual calibration: what stood where, what was measured, what remains."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from core.report.pages import read, read_svg
from core.robot import robots
from core.shoe import shoes
from shoecal_core.errors import ShoecalError
from shoecal_core.manual.calibrate import (
    CellsCalibration,
    ManualCalibration,
    calibrate_cells,
    calibrate_shoe,
)
from shoecal_core.report.calibration.manual_report import (
    ManualReport,
    known_loads,
    manual_page,
    manual_report,
)
from shoecal_core.report.figures.tracks import ChannelTrack, tracks
from shoecal_core.report.html import render
from shoecal_core.report.quantities import mean_error
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workflows.simulated_manual import simulate_manual
from shoecal_core.workspace import config_dir


@pytest.fixture(scope="module")
def found() -> tuple[CellsCalibration, ManualCalibration]:
    """Both steps on the simulated bench."""
    robot, shoe = robots.load("nao"), shoes.shoe("nao_shoe")
    reality = load_reality(config_dir() / "realities" / "default.yaml")
    cells, loads = simulate_manual(shoe, reality, 3, 3)
    first = calibrate_cells(shoe, robot, cells)
    return first, calibrate_shoe(shoe, robot, first.calibration, loads, fits=first.cells)


@pytest.fixture(scope="module")
def content(found: tuple[CellsCalibration, ManualCalibration]) -> ManualReport:
    _, whole = found
    return ManualReport(
        robots.load("nao"), shoes.shoe("nao_shoe"), whole.calibration, whole.cells, whole.feet,
        ("Simulated.",),
    )  # fmt: skip


def spaced(text: str) -> str:
    return " ".join(text.split())


def test_a_whole_report(content: ManualReport, tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    manual_report(path, content)
    html = path.read_text(encoding="utf-8")
    document = read(html)
    # Force, CoP before and after of each shoe; the cells of each shoe.
    assert document.tags["svg"] == 2 * 3 + 2
    assert not re.search(r"https?:", html)
    for foot in content.feet:
        assert spaced(mean_error(foot.grf, "mN", 1e3)) in document.text
        for mae in (foot.known_cop.before, foot.known_cop.after, foot.known_cop.held_out):
            assert spaced(mean_error(mae, "mm", 1e3)) in document.text
    for name in content.shoe.names:
        assert name in document.text
    for word in ("Left shoe", "CoP corrected", "shifted by assembling", "Simulated.",
                 content.calibration.id):  # fmt: skip
        assert word in document.text


def test_single_cells_alone(
    found: tuple[CellsCalibration, ManualCalibration], content: ManualReport
) -> None:
    first, _ = found
    text = read(
        render(
            manual_page(ManualReport(content.robot, content.shoe, first.calibration, first.cells))
        )
    ).text
    assert "first step of two" in text
    assert "load the shoe next" in text
    assert "Under known weights" not in text
    assert "shifted by assembling" not in text


def test_cells_that_were_fitted_elsewhere_have_no_residuals(content: ManualReport) -> None:
    text = read(render(manual_page(replace(content, cells=())))).text
    assert "about its own line" not in text
    assert "Single cells of" not in text


def test_a_correction_that_was_not_kept_is_not_drawn(content: ManualReport) -> None:
    (left, right) = content.calibration.corrections
    bare = replace(content, calibration=replace(content.calibration, corrections=(right,)))
    text = read(render(manual_page(bare))).text
    assert text.count("CoP corrected") == 1
    assert "none: it did not help" in text
    assert left.foot == 0


def test_places_are_those_of_the_holes(content: ManualReport) -> None:
    """Drawn around the hole, a CoP is as far from it as it was off what the load makes it."""
    foot = content.feet[0]
    drawn = known_loads(content, foot)
    error = np.linalg.norm(drawn.measured - drawn.places, axis=1)
    assert error.mean() == pytest.approx(foot.known_cop.before.mean)
    error = np.linalg.norm(drawn.corrected - drawn.places, axis=1)
    assert error.mean() == pytest.approx(foot.known_cop.after.mean)


def test_cells_about_their_lines() -> None:
    cells = [ChannelTrack(f"left/{n}", np.arange(3.0), np.arange(3.0)) for n in range(9)]
    root = read_svg(tracks(cells, "mass on the cell (kg)", "Δ force (mN)"))
    assert "left/8 0, 1, 2" in root.attrib["aria-label"]
    assert {"left/0", "mass on the cell (kg)"} <= set(root.itertext())


def test_content_that_does_not_fit(content: ManualReport) -> None:
    with pytest.raises(ShoecalError, match="needs cells or loaded shoes"):
        replace(content, cells=(), feet=())
    with pytest.raises(ShoecalError, match="other channels than shoe"):
        replace(content, shoe=shoes.shoe("odd_shoe"))
