"""`shoecal manual`: readings in files, and the simulated bench."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from core.cli.conftest import ROOT, SHOE, Run
from core.shoe import mutations
from shoecal_core.estimation.calibration import load_calibration


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("manual")


@pytest.fixture
def simulated_bench(shoecal: Run, folder: Path) -> Path:
    """A simulated bench's files, made once."""
    if not (folder / "calibration.yaml").exists():
        code, out, error = shoecal(
            "manual", "simulate", "--seed", 3, "--out", folder, "--json", folder / "figures.json",
            "--report", folder / "report.html",
        )  # fmt: skip
        assert code == 0, error
        assert "PASS: every check passed" in out
    return folder


def test_the_bench_leaves_readings_and_both_calibrations(simulated_bench: Path) -> None:
    figures = json.loads((simulated_bench / "figures.json").read_text())
    assert (figures["verdict"], figures["seed"], figures["robot_seed"]) == ("PASS", 3, 3)
    for side in ("left", "right"):
        foot = figures["manual"][side]
        assert foot["loads"] == 126
        assert foot["grf_mae_n"] < 0.03
        assert 3.0 < foot["cop_before_mm"] < 5.0
        assert foot["cop_after_mm"] < foot["cop_held_out_mm"] < 1.0
    assert "the bench are simulated" in (simulated_bench / "report.html").read_text()
    assert load_calibration(simulated_bench / "cells.yaml").corrections == ()
    final = load_calibration(simulated_bench / "calibration.yaml")
    assert (final.source, final.verdict) == ("manual", "PASS")


def test_solving_the_files_again_gives_the_same(
    shoecal: Run, simulated_bench: Path, tmp_path: Path
) -> None:
    cells, out = tmp_path / "cells.yaml", tmp_path / "calibration.yaml"
    code, told, error = shoecal(
        "manual", "cells", simulated_bench / "cells_data.yaml", "--out", cells,
        "--json", tmp_path / "cells.json", "--report", tmp_path / "cells.html",
    )  # fmt: skip
    assert code == 0, error
    assert "first step of two" in (tmp_path / "cells.html").read_text()
    assert "WARN: single cells only" in told
    assert cells.read_bytes() == (simulated_bench / "cells.yaml").read_bytes()
    figures = json.loads((tmp_path / "cells.json").read_text())
    assert figures["residual_std_n"]["left/front_left"] < 0.1
    # Without --cells it is looked for beside the data.
    for words in ((), ("--cells", cells)):
        code, _, error = shoecal(
            "manual", "shoe", simulated_bench / "shoe_data.yaml", "--out", out,
            "--report", tmp_path / "shoe.html", *words
        )  # fmt: skip
        assert code == 0, error
        assert out.read_bytes() == (simulated_bench / "calibration.yaml").read_bytes()
        assert "Errors under known weights" in (tmp_path / "shoe.html").read_text()


def test_the_cells_are_those_of_the_sessions_robot(shoecal: Run, tmp_path: Path) -> None:
    found = []
    for seed in (1, 2):
        code, _, error = shoecal(
            "manual", "simulate", "--seed", seed, "--robot-seed", 7, "--out", tmp_path / str(seed)
        )
        assert code == 0, error
        found.append(load_calibration(tmp_path / str(seed) / "calibration.yaml"))
    assert found[0].id != found[1].id
    assert found[0].parameters.gain == pytest.approx(found[1].parameters.gain, rel=2e-3)


def failed(run: tuple[int, str, str], *texts: str) -> None:
    code, _, error = run
    assert code == 1
    assert error.count("\n") == 1
    for text in texts:
        assert text in error


def test_wrong_use_is_one_line(shoecal: Run, simulated_bench: Path, tmp_path: Path) -> None:
    data, cells = simulated_bench / "shoe_data.yaml", simulated_bench / "cells_data.yaml"
    out = tmp_path / "out.yaml"
    nowhere = tmp_path / "nowhere.yaml"
    failed(shoecal("manual", "cells", nowhere, "--out", out), "nowhere.yaml", "--live")
    failed(shoecal("manual", "cells", data, "--out", out), "holds readings of 'shoe'")
    failed(shoecal("manual", "shoe", cells, "--out", out), "holds readings of 'cells'")
    failed(shoecal("manual", "shoe", data, "--out", out, "--cells", nowhere), "nowhere.yaml")
    alone = tmp_path / "shoe_data.yaml"
    alone.write_bytes(data.read_bytes())
    failed(shoecal("manual", "shoe", alone, "--out", out), "cells.yaml: does not exist", "--cells")
    failed(
        shoecal("manual", "cells", cells, "--out", tmp_path / "no" / "out.yaml"),
        "no: does not exist; make it first, for out.yaml",
    )
    failed(shoecal("manual", "cells", cells, "--out", out, "--from", tmp_path), "is a folder")
    failed(shoecal("manual", "cells", cells, "--out", out, "--from", nowhere), "cannot be read")
    assert not out.exists()


def test_a_shoe_without_holes_says_so(shoecal: Run, simulated_bench: Path, tmp_path: Path) -> None:
    robot = ROOT / "test" / "data" / "robots" / "odd_biped.yaml"
    words = ("--shoe", SHOE, "--robot", robot)
    failed(
        shoecal("manual", "simulate", "--out", tmp_path, *words),
        "odd_shoe.yaml: feet.left.holes: is missing",
    )


def test_one_bad_reading_is_named_with_its_file(
    shoecal: Run, simulated_bench: Path, tmp_path: Path
) -> None:
    data = tmp_path / "shoe_data.yaml"
    out = tmp_path / "out.yaml"
    mutations.write_edited(
        data, simulated_bench / "shoe_data.yaml", (("entries", 5, "mass_kg"), 1.75)
    )
    words = ("manual", "shoe", data, "--out", out, "--cells", simulated_bench / "cells.yaml")
    failed(shoecal(*words), f"{data}: left shoe, 1.75 kg in hole b2: weighs 1.00 kg")
    assert not out.exists()


def test_a_calibration_that_must_not_be_used_is_not_written(
    shoecal: Run, simulated_bench: Path, tmp_path: Path
) -> None:
    data = tmp_path / "cells_data.yaml"
    out = tmp_path / "out.yaml"
    # Every weight was twice what was said: no gain is unlike the others, the shoe will tell. One
    # weight was an eighth: its cell's gain is.
    mutations.write_edited(
        data,
        simulated_bench / "cells_data.yaml",
        (("entries", 1, "mass_kg"), 8.0),
        (("entries", 2, "mass_kg"), 16.0),
    )
    run = shoecal("manual", "cells", data, "--out", out)
    failed(run, "no calibration written", "left/front_left has gain")
    assert "left/front_left has gain" not in run[1]
    assert not out.exists()


@pytest.mark.parametrize("before", [True, False])
def test_figures_are_asked_for_before_or_behind_the_task(
    shoecal: Run, simulated_bench: Path, tmp_path: Path, before: bool
) -> None:
    figures = tmp_path / "figures.json"
    asked = ("--json", figures)
    task = ("cells", simulated_bench / "cells_data.yaml", "--out", tmp_path / "out.yaml")
    words = (*asked, *task) if before else (*task, *asked)
    assert shoecal("manual", *words)[0] == 0
    assert json.loads(figures.read_text())["verdict"] == "WARN"


def test_one_shoe_of_a_pair_without_the_other(
    shoecal: Run, simulated_bench: Path, tmp_path: Path
) -> None:
    """Readings of the left shoe alone: with --foot they are enough."""
    for name in ("cells_data.yaml", "shoe_data.yaml"):
        lines = (simulated_bench / name).read_text().splitlines()
        left = [line for line in lines if '"right' not in line]
        (tmp_path / name).write_text("\n".join(left) + "\n")
    words = ("manual", "cells", tmp_path / "cells_data.yaml", "--out", tmp_path / "cells.yaml")
    code, _, error = shoecal(*words)
    assert code == 1
    assert "no readings of right/front_left" in error
    code, _, error = shoecal(*words, "--foot", "left")
    assert code == 0, error
    code, told, error = shoecal(
        "manual", "shoe", tmp_path / "shoe_data.yaml", "--foot", "left",
        "--out", tmp_path / "left.yaml", "--json", tmp_path / "left.json",
        "--report", tmp_path / "left.html",
    )  # fmt: skip
    assert code == 0, error
    assert "right" not in told
    found = load_calibration(tmp_path / "left.yaml")
    whole = load_calibration(simulated_bench / "calibration.yaml")
    assert (found.verdict, found.channels) == ("PASS", whole.channels[:4])
    assert found.parameters.gain.tolist() == whole.parameters.gain[:4].tolist()
    assert list(json.loads((tmp_path / "left.json").read_text())["manual"]) == ["left"]
