"""`shoecal recover FILE|SESSION`: rescue what can be read of damaged run files."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console

from shoecal_core.cli.prose import say
from shoecal_core.errors import FileMissingError, ShoecalError
from shoecal_core.recording.recover import recover, recovered_path
from shoecal_core.recording.session import Session
from shoecal_core.recording.writer import PART


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument(
        "file",
        type=Path,
        help="the damaged run file, or a session's folder: all its interrupted runs; they are left "
        "as they are",
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="the file to make (default: next to it; never overwritten)",
    )


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Rescue the file, or each interrupted run of the folder."""
    if not args.file.is_dir():
        return _rescued(args.file, args.out or recovered_path(args.file), console)
    if args.out is not None:
        raise ShoecalError(f"--out: {args.file} is a folder; leave --out out, or name one run file")
    parts = Session.open(args.file, force=True).unfinished
    if not parts:
        raise FileMissingError(
            args.file, f"holds no interrupted run (run_NNN.mcap{PART}); name a damaged run file"
        )
    return {"runs": [_rescued(part, recovered_path(part), console) for part in parts]}


def _rescued(path: Path, out: Path, console: Console) -> Mapping[str, object]:
    report = recover(path, out)
    say(console, str(report))
    return {
        "out": str(report.out),
        "run": report.info.run,
        "messages": report.messages,
        "rescued_s": (report.end_ns - report.start_ns) / 1e9,
        "holes": [list(hole) for hole in report.holes_ns],
        "whole_end": report.whole_end,
    }
