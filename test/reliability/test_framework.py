"""Rows of faults: results that are kept, merged and shown."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from argparse import Namespace
from pathlib import Path

import pytest

import faults
import shoecal_core
import shoecal_ros
from pages import ROOT
from reliability import live_world, serial_counter, sources
from reliability.kept import Kept
from reliability.page import write_json, write_page
from reliability.row import Progress, Result, Row, Run, merge
from reliability.rows import Found, find_row, find_rows
from reliability.shown import Shown
from shoecal_core.errors import FileError

SUITE = [Path(package.__path__[0]) for package in (shoecal_core, shoecal_ros)]


class KilledError(Exception):
    """Stands for a kill -9 in the midst of a step."""


def row(run: Run, tries: int = 25, step: int = 10) -> Row:
    return Row("odd", "odd | numbers", "all even", tries, step, run)


def kept(folder: Path, one: Row | None = None, code: str = "now") -> Kept:
    return Kept(one or row(odd), folder / "faults", 0, code)


def odd(first: int, count: int, seed: int, progress: Progress) -> Result:
    """Tries whose number is odd fail; the largest is the worst."""
    progress(count)
    failed = sum(index % 2 for index in range(first, first + count))
    return Result(count, failed, f"at {first + count - 1}", float(first + count - 1))


def test_the_worst_of_several_results_is_one_that_failed() -> None:
    merged = merge([Result(5, 0, "9 s", 9.0), Result(5, 1, "3 s", 3.0), Result(2, 0, "1 s", 1.0)])
    assert merged == Result(12, 1, "3 s", 3.0)


def test_what_is_counted_is_that_of_all_tries() -> None:
    some = [Result(5, 0, "9 s", 9.0, {"old": 3, "new": 2}), Result(2, 0, "", 1.0, {"old": 1_000})]
    assert merge([some[0], some[0]]).told == "9 s; 6 old, 4 new"
    # Where some have not counted, there is no sum.
    assert merge(some).told == "9 s; 1,003 old"
    assert merge([*some, Result(1, 0, "")]).told == "9 s"


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
        faults.run_row(row(killed_once), kept(tmp_path, row(killed_once)), 1.0, fresh=False)
    faults.run_row(row(killed_once), kept(tmp_path, row(killed_once)), 1.0, fresh=False)
    assert begun == [0, 10, 10, 20]
    whole = kept(tmp_path).result
    assert whole == Result(25, 12, "at 24", 24.0)


def test_a_process_that_was_killed_leaves_whole_results(tmp_path: Path) -> None:
    command = [sys.executable, faults.__file__, "--alone", "serial_counter"]
    command += ["--kept", str(tmp_path / "faults")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as killed:
        assert killed.stdout is not None
        assert killed.stdout.readline().startswith(b"serial-counter: 500 of 10,000")
        killed.kill()
    left = kept(tmp_path, serial_counter.ROW, find_rows()["serial-counter"].code)
    assert left.result.tried >= 500
    assert left.present == left.result.tried
    assert next(left.missing(1.0))[0] == left.result.tried


def test_a_share_is_filled_up_to_the_full_size(tmp_path: Path) -> None:
    def missing(share: float) -> list[tuple[int, int]]:
        return list(kept(tmp_path).missing(share))

    assert missing(0.5) == [(0, 10), (10, 3)]
    faults.run_row(row(odd), kept(tmp_path, row(odd)), 0.5, fresh=False)
    assert missing(0.5) == []
    assert missing(1.0) == [(13, 7), (20, 5)]
    faults.run_row(row(odd), kept(tmp_path, row(odd)), 1.0, fresh=False)
    assert kept(tmp_path).result.tried == 25
    faults.run_row(row(odd), kept(tmp_path, row(odd)), 0.1, fresh=True)
    assert kept(tmp_path).result.tried == 3


def test_tries_after_one_that_ended_a_step_are_done_by_the_next_call(tmp_path: Path) -> None:
    """One that fails in a way that nothing can go on from."""
    begun = []

    def ends_at_12(first: int, count: int, seed: int, progress: Progress) -> Result:
        begun.append((first, count))
        last = first + count
        return Result(3, 1, "broken") if first <= 12 < last else odd(first, count, seed, progress)

    def even(first: int, count: int, seed: int, progress: Progress) -> Result:
        begun.append((first, count))
        return Result(count, 0, "")

    faults.run_row(row(ends_at_12), kept(tmp_path, row(ends_at_12)), 1.0, fresh=False)
    found = kept(tmp_path).result
    assert (found.tried, found.failed) == (10 + 3 + 5, 5 + 1 + 2)
    faults.run_row(row(even), kept(tmp_path, row(even)), 1.0, fresh=False)
    assert begun == [(0, 10), (10, 10), (20, 5), (13, 7)]
    found = kept(tmp_path).result
    assert (found.tried, found.failed) == (25, 5 + 1 + 2), "what has failed once stays"


def test_tries_that_are_missing_without_a_reason_are_a_fault(tmp_path: Path) -> None:
    def lazy(first: int, count: int, seed: int, progress: Progress) -> Result:
        return Result(count - 1, 0, "")

    with pytest.raises(ValueError, match="9 tries were done, not 10"):
        faults.run_row(row(lazy), kept(tmp_path, row(lazy)), 1.0, fresh=False)


def test_what_ran_with_other_code_is_done_anew_unless_it_shall_count(tmp_path: Path) -> None:
    faults.run_row(row(odd), kept(tmp_path, code="before"), 0.4, fresh=False)
    faults.run_row(row(odd), kept(tmp_path), 1.0, fresh=False, earlier_counts=True)
    assert (kept(tmp_path).result.tried, kept(tmp_path).present) == (25, 15)
    assert kept(tmp_path, code="later").present == 0
    faults.run_row(row(odd), kept(tmp_path), 1.0, fresh=False)
    assert (kept(tmp_path).result, kept(tmp_path).present) == (Result(25, 12, "at 24", 24.0), 25)


@pytest.mark.parametrize(
    ("code", "earlier_counts", "told"),
    [
        ("now", False, "with this very code"),
        ("before", True, "with this code or an earlier one"),
    ],
)
def test_a_row_of_which_nothing_is_left_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], code: str, earlier_counts: bool, told: str
) -> None:
    def again() -> None:
        faults.run_row(row(odd), kept(tmp_path), 1.0, fresh=False, earlier_counts=earlier_counts)

    line = f"odd: 25 tries were done {told}; --fresh does them again"
    faults.run_row(row(odd), kept(tmp_path, code=code), 0.4, fresh=False)
    again()
    assert line not in capsys.readouterr().out
    again()
    assert line in capsys.readouterr().out


def test_a_rows_process_is_told_whether_earlier_tries_count(tmp_path: Path) -> None:
    found = find_row("serial_counter")
    assert found is not None
    asked = Namespace(share=0.001, seed=0, kept=tmp_path / "faults", fresh=False)
    faults.run_row(found.row, kept(tmp_path, found.row, "before"), asked.share, fresh=False)
    for asked.earlier_counts, present in (True, 0), (False, 10):
        assert faults.run_apart(found, asked)
        assert kept(tmp_path, found.row, found.code).present == present


def test_results_from_before_codes_were_kept_count_as_other_code(tmp_path: Path) -> None:
    (tmp_path / "faults").mkdir()
    piece = {"tried": 10, "failed": 0, "worst": "fine", "figure": 1.0}
    held = {"seed": 0, "step": 10, "steps": {"0": piece}}
    (tmp_path / "faults" / "odd.json").write_text(json.dumps(held))
    assert (kept(tmp_path).result.tried, kept(tmp_path).present) == (10, 0)
    faults.run_row(row(odd), kept(tmp_path), 1.0, fresh=False, earlier_counts=True)
    assert (kept(tmp_path).result.tried, kept(tmp_path).present) == (25, 15)


def test_a_digest_is_of_what_a_row_can_reach() -> None:
    codes = {found.code for found in find_rows().values()}
    assert len(codes) == len(find_rows()), "each has a module of its own"
    used = {path.name for path in sources.used("reliability.mutated_calibrations")}
    assert {"mutated_calibrations.py", "loading.py", "row.py"} <= used
    assert {"calibration.py", "files.py", "errors.py"} <= used
    assert used.isdisjoint({"soak.py", "planner.py", "cobs.py"})


def test_what_starts_nodes_reaches_what_those_can() -> None:
    used = sources.used("reliability.flood")
    names = {path.name for path in used}
    assert {"world.py", "bodies.py", "flood_caller.py"} <= names
    assert {
        "calibrator.py",
        "live.py",
        "active_calibration.py",
        "process.py",
        "solving_work.py",
    } <= names
    # Other nodes, and commands, are none of its concern.
    assert names.isdisjoint({"controller_adapter.py", "simulator.py", "conductor.py"})
    assert {path.name for path in sources.used("reliability.killed_nodes")} >= {
        "simulator.py", "shoe_driver.py", "model.py", "planner.py", "calibrator.py",
    }  # fmt: skip


def test_configuration_and_messages_count_where_they_are_used() -> None:
    live, bare = sources.used("reliability.stale"), sources.used("reliability.serial_random")
    for file in ("config/robots/nao.urdf", "config/nodes/calibrator.yaml"):
        assert ROOT / file in live
        assert ROOT / file not in bare
    messages = set((ROOT / "shoecal_msgs").glob("*/*.*"))
    assert messages
    assert messages <= live
    assert messages.isdisjoint(bare)


def test_files_of_data_count_where_they_are_named() -> None:
    live, bare = sources.used("reliability.stale"), sources.used("reliability.serial_random")
    data = {ROOT / "test" / "ros" / "quick_discovery.xml"}
    # The URDF is named by the robot's file.
    data |= {ROOT / "test" / "data" / "robots" / f"odd_biped.{kind}" for kind in ("yaml", "urdf")}
    assert data <= live
    assert data.isdisjoint(bare)


def test_pages_results_and_what_is_no_file_of_the_project_do_not_count(tmp_path: Path) -> None:
    (tmp_path / "beside.yaml").touch()
    program = tmp_path / "names.py"
    program.write_text(
        "f''\n'docs/evidence/reliability.md'\n'docs/evidence/reliability/soak.json'\n'/etc/passwd'\n"
        "'test/data/robots'\n'beside.yaml'\n'test/data/shoes/odd_shoe.yaml'\n"
    )
    assert sources._reached(program) == {ROOT / "test" / "data" / "shoes" / "odd_shoe.yaml"}


def test_a_row_that_needs_the_tests_helpers_finds_them() -> None:
    """It runs in a process of its own, where `live_world` makes them importable."""
    helpers = ROOT / "test"
    for found in find_rows().values():
        used = sources.used(f"reliability.{found.module}")
        if any(path.is_relative_to(helpers) for path in used):
            assert Path(live_world.__file__) in used, found.row.key


def test_a_row_reaches_what_it_loads() -> None:
    """Whatever of the suite is loaded when a row is has been counted."""
    for module in ("serial_random", "killed_saving", "clock_jumps"):
        program = (
            f"import sys; from reliability import {module}; "
            "print(*[m.__file__ for m in sys.modules.values() if getattr(m, '__file__', None)])"
        )
        told = subprocess.run(
            [sys.executable, "-c", program],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)},
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        loaded = {Path(file) for file in told.stdout.split()}
        suite = {path for path in loaded for folder in SUITE if path.is_relative_to(folder)}
        assert suite
        assert suite <= sources.used(f"reliability.{module}"), module


def test_results_of_another_seed_or_no_results_are_refused(tmp_path: Path) -> None:
    faults.run_row(row(odd), kept(tmp_path, row(odd)), 0.1, fresh=False)
    with pytest.raises(FileError, match="seed 0, not 1; remove it to begin anew"):
        Kept(row(odd), tmp_path / "faults", 1)
    (tmp_path / "faults" / "odd.json").write_text("[]")
    with pytest.raises(FileError, match="no file of results"):
        kept(tmp_path)


def test_steps_of_another_size_are_filled_up(tmp_path: Path) -> None:
    faults.run_row(row(odd), kept(tmp_path), 0.5, fresh=False)
    other = row(odd, step=4)
    assert list(kept(tmp_path, other).missing(1.0)) == [(13, 3), (16, 4), (20, 4), (24, 1)]
    faults.run_row(other, kept(tmp_path, other), 1.0, fresh=False)
    assert kept(tmp_path).result == Result(25, 12, "at 23", 23.0)
    # Done anew, each is done once, however it was cut before.
    faults.run_row(row(odd), kept(tmp_path, code="later"), 1.0, fresh=False)
    assert kept(tmp_path, code="later").present == 25
    assert kept(tmp_path).result == Result(25, 12, "at 24", 24.0)


def test_what_failed_with_this_code_is_told_when_it_is_done_again(tmp_path: Path) -> None:
    def well(first: int, count: int, seed: int, progress: Progress) -> Result:
        return Result(count, 0, "", 0.0)

    def again(code: str = "now", run: Run = well, *, fresh: bool = True) -> Kept:
        faults.run_row(row(run), kept(tmp_path, row(run), code), 1.0, fresh=fresh)
        return kept(tmp_path, code=code)

    again("before", odd, fresh=False)
    assert again(run=odd).before == merge([]), "that was other code"
    one = again()
    assert (one.result.failed, one.present) == (0, 25)
    assert one.before == Result(25, 12, "at 24", 24.0)
    assert again().before == one.before, "nothing more has failed"
    again(run=odd)
    assert again().before == Result(50, 24, "at 24", 24.0)
    assert again("later", fresh=False).before == merge([])


def test_what_failed_is_told_though_the_new_tries_were_killed(tmp_path: Path) -> None:
    def killed(first: int, count: int, seed: int, progress: Progress) -> Result:
        raise KilledError

    faults.run_row(row(odd), kept(tmp_path), 1.0, fresh=False)
    with pytest.raises(KilledError):
        faults.run_row(row(killed), kept(tmp_path, row(killed)), 1.0, fresh=True)
    assert kept(tmp_path).result == merge([])
    assert kept(tmp_path).before.failed == 12
    assert kept(tmp_path, code="later").before.failed == 12, "until that code has been tried"


def test_a_step_that_is_repeated_alone_is_told(tmp_path: Path) -> None:
    faults.run_row(row(odd), kept(tmp_path), 1.0, fresh=False)
    kept(tmp_path, row(lambda *_: Result(10, 0, ""))).run(10, 10, lambda _: None)
    assert kept(tmp_path).before == Result(10, 5, "at 19", 19.0)


ODD = Found(row(odd), "What it does.", "odd")
NONE = merge([])


def test_page(tmp_path: Path) -> None:
    long = "worse, " * 30
    rows = {
        "odd": Shown(ODD, odd(0, 4, 0, lambda _: None), 3, NONE),
        "again": Shown(ODD, Result(25, 0, "fine"), 25, Result(50, 2, "at 7")),
        "long": Shown(ODD, Result(25, 25, long), 0, NONE),
        "none": Shown(ODD, NONE, 0, NONE),
    }
    page = tmp_path / "page.md"
    for _ in range(2):
        write_page(rows, page)
    text = page.read_text()
    assert text.count("| [`odd`](#odd) | all even | 4 of 25 | 3 | **2** | at 3 |") == 1
    once_more = "before, with the same code, 2 of 50: at 7"
    assert f"| [`again`](#again) | all even | 25 | all | 0; {once_more} | fine |" in text
    assert "| [`none`](#none) | all even | 0 of 25 |  |  | not tried |" in text
    assert "### `odd`\n\nFault: odd | numbers.\n\nWhat it does. ([details](" in text
    assert text.count(long.strip()) == 1, "in its own section alone"
    some = "3 of [`odd`](#odd)"
    for line in (
        "- **4 rows**, 2 of them tried in full.",
        "- Tried in part: [`odd`](#odd) (4 of 25).",
        "- Not tried: [`none`](#none).",
        "- **Failed** in 2 rows:",
        "    - [`odd`](#odd), 2 of 4: at 3",
        "- Failed before, with the same code, in 1 row:",
        "    - [`again`](#again), 2 of 50: at 7",
        f"- **This very code** ran in all tries of 1 row, {some} and none of 1 row (earlier code).",
    ):
        assert f"\n{line}\n" in text, line


def test_page_of_rows_that_hold(tmp_path: Path) -> None:
    write_page({"odd": Shown(ODD, Result(25, 0, "fine"), 25, NONE)}, tmp_path / "page.md")
    text = (tmp_path / "page.md").read_text()
    assert "\n- **Failed** in none.\n- **This very code** ran in all tries of 1 row.\n" in text


def test_figures(tmp_path: Path) -> None:
    rows = {
        "odd": Shown(ODD, odd(0, 4, 0, lambda _: None), 3, NONE),
        "again": Shown(ODD, Result(25, 0, "fine"), 25, Result(50, 2, "at 7")),
        "none": Shown(ODD, NONE, 0, NONE),
    }
    write_json(rows, tmp_path / "faults.json")
    assert json.loads((tmp_path / "faults.json").read_text()) == [
        {"fault": "odd | numbers", "tried": tried, "failed": failed, "worst": worst}
        for tried, failed, worst in (
            (4, 2, "at 3"),
            (25, 0, "fine; before, with the same code, 2 of 50: at 7"),
            (0, 0, "not tried"),
        )
    ]


def test_every_row_explains_itself() -> None:
    for key, found in find_rows().items():
        assert found.about, f"{key}: its module has no docstring"
        assert found.row.tries % found.row.step == 0, f"{key}: steps do not fill it"


def test_a_row_that_there_is_not(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        faults.main(["--only", "no-such-row"])
    assert "no row no-such-row" in capsys.readouterr().err
