"""Rows of faults: results that are kept, merged and shown."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

import faults
from reliability import rows, serial_counter
from reliability.kept import Kept
from reliability.page import write_json, write_page
from reliability.row import Progress, Result, Row, Run, merge
from reliability.rows import Found, find_rows
from shoecal_core.errors import FileError


class KilledError(Exception):
    """Stands for a kill -9 during a step."""


def odd(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Tries whose number is odd fail; the largest is the worst."""
    progress(count)
    failed = sum(index % 2 for index in range(first, first + count))
    return Result(count, failed, f"at {first + count - 1}", float(first + count - 1))


def row(run: Run = odd, step: int = 10) -> Row:
    return Row("odd", "odd | numbers", "all even", 25, step, run)


def run_all(
    monkeypatch: pytest.MonkeyPatch,
    folder: Path,
    one: Row,
    share: float = 1.0,
    *,
    fresh: bool = False,
) -> Result:
    """Run what is missing of a row, in this process."""
    monkeypatch.setattr(faults, "rows_of", lambda module: {"odd": Found(one, module, "")})
    faults.run_row("module", "odd", folder, share, 0, fresh)
    return Kept(one, folder, 0).result


def test_the_worst_of_several_results_is_one_that_failed() -> None:
    merged = merge([Result(5, 0, "9 s", 9.0), Result(5, 1, "3 s", 3.0), Result(2, 0, "1 s", 1.0)])
    assert merged == Result(12, 1, "3 s", 3.0)
    assert merge([]) == Result(0, 0, "not tried")


def test_counts_are_those_that_all_tries_have() -> None:
    some = [Result(5, 0, "9 s", 9.0, {"old": 3, "new": 2}), Result(2, 0, "", 1.0, {"old": 1_000})]
    assert merge([some[0], some[0]]).text == "9 s; 6 old, 4 new"
    assert merge(some).text == "9 s; 1,003 old"
    assert merge([*some, Result(1, 0, "")]).text == "9 s"


def test_no_more_can_fail_than_was_tried() -> None:
    with pytest.raises(ValueError, match="3 of 2"):
        Result(2, 3, "")


def test_a_killed_run_continues(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    begun = []

    def killed_once(first: int, count: int, seed: int, progress: Progress) -> Result:
        begun.append(first)
        if begun == [0, 10]:
            raise KilledError
        return odd(first, count, seed, progress)

    with pytest.raises(KilledError):
        run_all(monkeypatch, tmp_path, row(killed_once))
    assert run_all(monkeypatch, tmp_path, row(killed_once)) == Result(25, 12, "at 24", 24.0)
    assert begun == [0, 10, 10, 20]


def test_a_process_that_was_killed_leaves_whole_results(tmp_path: Path) -> None:
    command = [sys.executable, faults.__file__, "--only", "serial-counter"]
    command += ["--page", str(tmp_path / "page.md"), "--out", str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, start_new_session=True) as killed:
        assert killed.stdout is not None
        assert killed.stdout.readline().startswith(b"serial-counter: 500 tries")
        os.killpg(killed.pid, signal.SIGKILL)
    left = Kept(serial_counter.ROW, tmp_path / "page", 0)
    assert left.result.tried >= 500
    assert left.next_step(1.0) == (left.result.tried, 500)


def test_a_share_is_filled_up_to_the_full_size(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run_all(monkeypatch, tmp_path, row(), 0.5).tried == 13
    assert Kept(row(), tmp_path, 0).next_step(0.5) == (13, 0)
    # The steps end where those of a full run end.
    assert Kept(row(), tmp_path, 0).next_step(1.0) == (13, 7)
    assert run_all(monkeypatch, tmp_path, row()).tried == 25
    assert run_all(monkeypatch, tmp_path, row(), 0.1, fresh=True).tried == 3


def test_a_failure_that_ends_a_step_does_not_end_the_row(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun = []

    def ends_at_12(first: int, count: int, seed: int, progress: Progress) -> Result:
        begun.append((first, count))
        ends = first <= 12 < first + count
        return Result(3, 1, "broken") if ends else Result(count, 0, "")

    found = run_all(monkeypatch, tmp_path, row(ends_at_12))
    assert (found.tried, found.failed) == (25, 1)
    assert begun == [(0, 10), (10, 10), (13, 7), (20, 5)]


def test_tries_left_out_without_a_failure_are_an_error(tmp_path: Path) -> None:
    lazy = row(lambda *_: Result(9, 0, ""))
    with pytest.raises(ValueError, match="9 tries were run, not 10"):
        Kept(lazy, tmp_path, 0).run(0, 10, lambda _: None)


def test_a_finished_row_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for _ in range(2):
        run_all(monkeypatch, tmp_path, row())
    assert "odd: 25 tries are finished; --fresh runs them again" in capsys.readouterr().out


def test_results_of_another_seed_or_no_results_are_refused(tmp_path: Path) -> None:
    Kept(row(), tmp_path, 0).run(0, 10, lambda _: None)
    with pytest.raises(FileError, match="seed 0, not 1; --fresh starts again"):
        Kept(row(), tmp_path, 1)
    (tmp_path / "odd.json").write_text("[]")
    with pytest.raises(FileError, match="no file of results"):
        Kept(row(), tmp_path, 0)


def test_rows_run_in_processes_of_their_own(tmp_path: Path) -> None:
    arguments = ["--share", "0.001", "--out", str(tmp_path), "--page", str(tmp_path / "page.md")]
    assert faults.main(["--only", "serial-counter", *arguments]) == 0
    page = (tmp_path / "page.md").read_text()
    assert "back within 2 s" in page
    assert "| 10 of 10,000 | 0 |" in page
    assert json.loads((tmp_path / "page" / "serial-counter.json").read_text())["seed"] == 0


def test_a_failed_row_or_a_row_that_ends_early_gives_exit_code_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    found = {"odd": Found(row(), "odd", "")}
    monkeypatch.setattr(faults, "find_rows", lambda: found)
    page = tmp_path / "page.md"
    arguments = ["--out", str(tmp_path), "--page", str(page)]
    assert faults.main([*arguments, "--table"]) == 0
    assert faults.main(arguments) == 1, "there is no module of this name for its process"
    assert "odd: its process ended with 1" in capsys.readouterr().err
    Kept(row(), page.with_suffix(""), 0).run(0, 10, lambda _: None)
    assert faults.main([*arguments, "--table"]) == 1


def test_page(tmp_path: Path) -> None:
    one = Found(row(), "odd", "What it does.")
    shown = {
        "odd": (one, odd(0, 4, 0, lambda _: None)),
        "whole": (one, Result(25, 0, "fine", counts={"old": 1_000})),
        "none": (one, merge([])),
    }
    page = tmp_path / "page.md"
    for _ in range(2):
        write_page(shown, page)
    text = page.read_text()
    assert text.count("| [`odd`](#odd) | all even | 4 of 25 | **2** | at 3 |") == 1
    assert "| [`whole`](#whole) | all even | 25 | 0 | fine; 1,000 old |" in text
    assert "| [`none`](#none) | all even | 0 of 25 |  | not tried |" in text
    assert "### `odd`\n\nFault: odd | numbers.\n\nWhat it does. ([details](" in text
    write_json(shown, tmp_path / "faults.json")
    assert json.loads((tmp_path / "faults.json").read_text()) == [
        {"fault": "odd | numbers", "tried": tried, "failed": failed, "worst": worst}
        for tried, failed, worst in (
            (4, 2, "at 3"),
            (25, 0, "fine; 1,000 old"),
            (0, 0, "not tried"),
        )
    ]


def test_every_row_explains_itself_and_its_steps_fill_it() -> None:
    found = find_rows()
    assert found
    for key, one in found.items():
        assert one.about, f"{key}: its module has no docstring"
        assert one.row.tries % one.row.step == 0, key


def test_two_rows_of_one_key_are_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rows, "rows_of", lambda module: {"odd": Found(row(), module, "")})
    with pytest.raises(ValueError, match="two rows have the key odd"):
        find_rows()


def test_an_unknown_row_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        faults.main(["--only", "no-such-row"])
    assert "no row no-such-row" in capsys.readouterr().err
