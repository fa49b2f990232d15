"""Faults, tried very often: does the suite keep working, or say at once that it does not?

    .venv/bin/python benchmarks/faults.py [--share 0.1] [--only ROW ...] [--earlier-counts]

Every row runs in a process of its own. Finished steps are kept in docs/evidence/reliability/, so
a run that was stopped or killed is taken up where it was, on another computer too. What was tried
with other code than this is tried again; with --earlier-counts only what was never tried is.
--table runs nothing. Writes out/faults.json and docs/evidence/reliability.md; ends with 0 only if
nothing failed.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from pages import ROOT
from reliability.kept import Kept
from reliability.page import write_json, write_page
from reliability.row import Row
from reliability.rows import Found, find_row, find_rows
from reliability.shown import Shown
from shoecal_core.errors import ShoecalError

OUT = ROOT / "out"
PAGE = ROOT / "docs" / "evidence" / "reliability.md"
KEPT = PAGE.with_suffix("")
PROGRESS_S = 2.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the rows asked for; 0 if nothing failed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--share", type=float, default=1.0, help="of every row's full size")
    parser.add_argument("--only", nargs="+", metavar="ROW", help="these rows")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--fresh", action="store_true", help="do again what these rows have kept")
    parser.add_argument(
        "--earlier-counts",
        action="store_true",
        help="do only what was never tried, with whatever code",
    )
    parser.add_argument("--out", type=Path, default=OUT, help="folder of faults.json")
    parser.add_argument("--kept", type=Path, default=KEPT, help="folder of finished steps")
    parser.add_argument("--page", type=Path, default=PAGE, help="Markdown page with the table")
    parser.add_argument(
        "--table", action="store_true", help="run nothing; write the table of what is kept"
    )
    parser.add_argument("--alone", metavar="MODULE", help=argparse.SUPPRESS)
    args = parser.parse_args(arguments)
    if not 0.0 < args.share <= 1.0:
        parser.error("--share is more than 0 and at most 1")
    try:
        if args.alone:
            found = find_row(args.alone)
            assert found is not None
            one = Kept(found.row, args.kept, args.seed, found.code)
            run_row(
                found.row, one, args.share, fresh=args.fresh, earlier_counts=args.earlier_counts
            )
            return 0
        rows = find_rows()
        wanted = args.only or list(rows)
        if unknown := set(wanted).difference(rows):
            parser.error(f"no row {', '.join(sorted(unknown))}; there are {', '.join(rows)}")
        ended = [run_apart(rows[key], args) for key in wanted if not args.table]
        kept = {
            key: Kept(found.row, args.kept, args.seed, found.code) for key, found in rows.items()
        }
        failed = write(rows, kept, args.out / "faults.json", args.page)
    except ShoecalError as error:
        print(error, file=sys.stderr)
        return 1
    return 0 if all(ended) and not failed.intersection(wanted) else 1


def run_apart(found: Found, args: argparse.Namespace) -> bool:
    """Run a row in a process of its own; whether that came to its end."""
    command = [sys.executable, __file__, "--alone", found.module, "--share", str(args.share)]
    command += ["--seed", str(args.seed), "--kept", str(args.kept)]
    switches = {"--fresh": args.fresh, "--earlier-counts": args.earlier_counts}
    command += [option for option, given in switches.items() if given]
    done = subprocess.run(command, check=False)
    if done.returncode:
        print(f"{found.row.key}: its process ended with {done.returncode}", file=sys.stderr)
    return done.returncode == 0


def run_row(
    row: Row, kept: Kept, share: float, *, fresh: bool, earlier_counts: bool = False
) -> None:
    """Do what is missing of a row, step by step."""
    if fresh:
        kept.forget()
    steps = list(kept.missing(share, earlier_counts=earlier_counts))
    if not steps:
        tried, code = kept.present, "this very code"
        if earlier_counts:
            tried, code = kept.result.tried, "this code or an earlier one"
        print(f"{row.key}: {tried:,} tries were done with {code}; --fresh does them again")
    tries = sum(count for _, count in steps)
    done, began = 0, time.monotonic()
    for first, count in steps:
        result = kept.run(first, count, Teller(row.key, done, tries))
        done += count
        told = f"{result.failed} failed, " if result.failed else ""
        seconds = time.monotonic() - began
        line = f"{row.key}: {done:,} of {tries:,} in {seconds:.0f} s; {told}{result.told}"
        print(line, flush=True)
    print(f"{row.key}: {kept.result}", flush=True)


class Teller:
    """Tells on standard error how far a step is, now and then."""

    def __init__(self, key: str, before: int, tries: int) -> None:
        self._key, self._before, self._tries = key, before, tries
        self._told = time.monotonic()

    def __call__(self, done: int) -> None:
        """So many tries of the step are done."""
        if time.monotonic() - self._told >= PROGRESS_S:
            self._told = time.monotonic()
            print(f"{self._key}: {self._before + done:,} of {self._tries:,}", file=sys.stderr)


def write(
    rows: Mapping[str, Found], kept: Mapping[str, Kept], figures: Path, page: Path
) -> set[str]:
    """Write table and figures of all that is kept; rows that failed."""
    shown = {
        key: Shown(found, one.result, one.present, one.before)
        for key, found in rows.items()
        for one in (kept[key],)
    }
    write_json(shown, figures)
    write_page(shown, page)
    return {key for key, one in shown.items() if one.result.failed}


if __name__ == "__main__":
    sys.exit(main())
