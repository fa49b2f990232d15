"""Faults, tried very often: does the suite keep working, or report at once that it does not?

    .venv/bin/python benchmarks/faults.py [--share 0.1] [--only ROW ...] [--fresh] [--table]

Each row runs in its own process. Finished steps are kept in docs/evidence/reliability/, so that
a run that was stopped or killed continues, on another computer too. Writes the table of all rows
into docs/evidence/reliability.md and out/faults.json; ends with 0 only if nothing failed.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from pages import ROOT
from reliability.kept import Kept
from reliability.page import write_json, write_page
from reliability.row import Progress
from reliability.rows import Found, find_rows, rows_of
from shoecal_core.errors import ShoecalError

OUT = ROOT / "out"
PAGE = ROOT / "docs" / "evidence" / "reliability.md"
PROGRESS_S = 2.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the rows asked for; 0 if nothing failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--share", type=float, default=1.0, help="of every row's full size")
    parser.add_argument("--only", nargs="+", metavar="ROW", help="these rows")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--fresh", action="store_true", help="run again what is finished")
    parser.add_argument("--table", action="store_true", help="only write the table")
    parser.add_argument("--out", type=Path, default=OUT, help="folder of faults.json")
    parser.add_argument(
        "--page", type=Path, default=PAGE, help="Markdown; steps are kept in the folder of its name"
    )
    args = parser.parse_args(arguments)
    if not 0.0 < args.share <= 1.0:
        parser.error("--share is more than 0 and at most 1")
    rows, folder = find_rows(), args.page.with_suffix("")
    wanted = args.only or list(rows)
    if unknown := set(wanted).difference(rows):
        parser.error(f"no row {', '.join(sorted(unknown))}; there are {', '.join(rows)}")
    try:
        ended = [
            run_apart(rows[key], folder, args.share, args.seed, fresh=args.fresh)
            for key in wanted
            if not args.table
        ]
        shown = {
            key: (found, Kept(found.row, folder, args.seed).result) for key, found in rows.items()
        }
        write_json(shown, args.out / "faults.json")
        write_page(shown, args.page)
    except ShoecalError as error:
        print(error, file=sys.stderr)
        return 1
    return 0 if all(ended) and not any(shown[key][1].failed for key in wanted) else 1


def run_apart(found: Found, folder: Path, share: float, seed: int, *, fresh: bool) -> bool:
    """Run a row in its own process; whether the process ended well."""
    key = found.row.key
    Kept(found.row, folder, seed, fresh=fresh)  # an error of the file is reported here
    process = multiprocessing.get_context("spawn").Process(
        target=run_row, args=(found.module, key, folder, share, seed, fresh)
    )
    process.start()
    process.join()
    if process.exitcode:
        print(f"{key}: its process ended with {process.exitcode}", file=sys.stderr)
    return process.exitcode == 0


def run_row(module: str, key: str, folder: Path, share: float, seed: int, fresh: bool) -> None:
    """Run the missing steps of a row and keep each."""
    row = rows_of(module)[key].row
    kept = Kept(row, folder, seed, fresh=fresh)
    first, count = kept.next_step(share)
    if not count:
        print(f"{key}: {first:,} tries are finished; --fresh runs them again")
    while count:
        result = kept.run(first, count, reporter(key, first))
        failed = f"{result.failed} failed, " if result.failed else ""
        print(f"{key}: {first + result.tried:,} tries; {failed}{result.text}", flush=True)
        first, count = kept.next_step(share)


def reporter(key: str, first: int) -> Progress:
    """What prints the progress of a step on standard error, at most every PROGRESS_S seconds."""
    last = time.monotonic()

    def report(done: int) -> None:
        nonlocal last
        if time.monotonic() - last >= PROGRESS_S:
            last = time.monotonic()
            print(f"{key}: {first + done:,} tries", file=sys.stderr)

    return report


if __name__ == "__main__":
    sys.exit(main())
