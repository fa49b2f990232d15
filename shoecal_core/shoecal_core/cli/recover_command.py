"""`shoecal recover FILE`: rescue what can be read of a damaged run file."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console

from shoecal_core.recording.recover import recover, recovered_path


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("file", type=Path, help="the damaged run file; it is left as it is")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="FILE",
        help="the file to make (default: next to it; never overwritten)",
    )


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Rescue the file."""
    report = recover(args.file, args.out or recovered_path(args.file))
    console.print(str(report))
    return {
        "out": str(report.out),
        "run": report.info.run,
        "messages": report.messages,
        "rescued_s": (report.end_ns - report.start_ns) / 1e9,
        "holes": [list(hole) for hole in report.holes_ns],
        "whole_end": report.whole_end,
    }
