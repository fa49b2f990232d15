"""Rows of faults: results that are kept, merged and shown."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import faults
from reliability import serial_counter
from reliability.kept import Kept
from reliability.page import write_json, write_page
from reliability.row import Progress, Result, Row, Run, merge
from reliability.rows import Found, find_rows
from shoecal_core.errors import FileError


class KilledError(Exception):
    """Stands for a kill -9 in the midst of a step."""


def row(run: Run, tries: int = 25, step: int = 10) -> Row:
    return Row("odd", "odd | numbers", "all even", tries, step, run)


def odd(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Tries whose number is odd fail; the largest is the worst."""
    progress(count)
    failed = sum(index % 2 for index in range(first, first + count))
    return Result(count, failed, f"at {first + count - 1}", float(first + count - 1))


def test_the_worst_of_several_results_is_one_that_failed() -> None:
    merged = merge([Result(5, 0, "9 s", 9.0), Result(5, 1, "3 s", 3.0), Result(2, 0, "1 s", 1.0)])
    assert merged == Result(12, 1, "3 s", 3.0)


def test_nothing_tried_is_said() -> None:
    assert merge([]) == Result(0, 0, "not tried")


def test_no_more_can_fail_than_was_tried() -> None:
    with pytest.raises(ValueError, match="3 of 2"):
        Result(2, 3, "")


def test_a_killed_run_is_taken_up_where_it_was(tmp_path: Path) -> None:
    begun = []

    def killed_once(first: int, count: int, seed: int, progress: Progress) -> Result:
        begun.append(first)
        if begun == [0, 10]:
            raise KilledError
        return odd(first, count, seed, progress)

    with pytest.raises(KilledError):
        faults.run_row(row(killed_once), tmp_path, 1.0, 0, fresh=False)
    faults.run_row(row(killed_once), tmp_path, 1.0, 0, fresh=False)
    assert begun == [0, 10, 10, 20]
    whole = Kept(row(odd), tmp_path / "faults", 0).result
    assert whole == Result(25, 12, "at 24", 24.0)


def test_a_process_that_was_killed_leaves_whole_results(tmp_path: Path) -> None:
    command = [sys.executable, faults.__file__, "--alone", "serial_counter"]
    command += ["--out", str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as killed:
        assert killed.stdout is not None
        assert killed.stdout.readline().startswith(b"serial-counter: 500 of 10,000")
        killed.kill()
    kept = Kept(serial_counter.ROW, tmp_path / "faults", 0)
    assert kept.result.tried >= 500
    assert next(kept.missing(1.0))[0] == kept.result.tried


def test_a_share_is_filled_up_to_the_full_size(tmp_path: Path) -> None:
    def missing(share: float) -> list[tuple[int, int]]:
        return list(Kept(row(odd), tmp_path / "faults", 0).missing(share))

    assert missing(0.5) == [(0, 10), (10, 3)]
    faults.run_row(row(odd), tmp_path, 0.5, 0, fresh=False)
    assert missing(0.5) == []
    assert missing(1.0) == [(10, 10), (20, 5)]
    faults.run_row(row(odd), tmp_path, 1.0, 0, fresh=False)
    assert Kept(row(odd), tmp_path / "faults", 0).result.tried == 25
    faults.run_row(row(odd), tmp_path, 0.1, 0, fresh=True)
    assert Kept(row(odd), tmp_path / "faults", 0).result.tried == 3


def test_results_of_another_seed_or_no_results_are_refused(tmp_path: Path) -> None:
    faults.run_row(row(odd), tmp_path, 0.1, 0, fresh=False)
    with pytest.raises(FileError, match="seed 0, not 1; begin with --fresh"):
        Kept(row(odd), tmp_path / "faults", 1)
    (tmp_path / "faults" / "odd.json").write_text("[]")
    with pytest.raises(FileError, match="no file of results"):
        Kept(row(odd), tmp_path / "faults", 0)


def test_other_steps_begin_anew(tmp_path: Path) -> None:
    faults.run_row(row(odd), tmp_path, 1.0, 0, fresh=False)
    assert Kept(row(odd, step=5), tmp_path / "faults", 0).result.tried == 0


def test_page_and_figures(tmp_path: Path) -> None:
    rows = {
        "odd": Found(row(odd), "What it does.", "odd"),
        "none": Found(row(odd), "Not run.", "none"),
    }
    results = {"odd": odd(0, 4, 0, lambda _: None), "none": merge([])}
    page = tmp_path / "page.md"
    write_page(rows, results, page)
    write_page(rows, results, page)
    text = page.read_text()
    assert text.count("| `odd` | odd \\| numbers | all even | 25 | 4 | **2** | at 3 |") == 1
    assert "### `odd`\n\nWhat it does." in text
    write_json(rows, results, tmp_path / "faults.json")
    assert json.loads((tmp_path / "faults.json").read_text()) == [
        {"fault": "odd | numbers", "tried": 4, "failed": 2, "worst": "at 3"}
    ]


def test_every_row_explains_itself() -> None:
    for key, found in find_rows().items():
        assert found.about, f"{key}: its module has no docstring"
        assert found.row.tries % found.row.step == 0, f"{key}: steps do not fill it"


def test_a_row_that_there_is_not(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        faults.main(["--only", "no-such-row"])
    assert "no row no-such-row" in capsys.readouterr().err
