"""`shoecal import csv MAPPING FOLDER`: turn foreign recordings into a session."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console

from shoecal_core.recording.csv_import import import_csv


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("kind", choices=("csv",), help="how the recordings are stored")
    parser.add_argument("mapping", type=Path, help="YAML file that says what the columns mean")
    parser.add_argument("folder", type=Path, help="where the recordings are; left as it is")
    parser.add_argument(
        "--out", type=Path, metavar="DIR", required=True, help="the session to make"
    )


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Import the recordings."""
    session = import_csv(args.mapping, args.folder, args.out)
    runs = [{"run": entry.run, "motion": entry.info.motion} for entry in session.runs]
    console.print(f"{args.out}: {len(runs)} runs of robot '{session.robot}'")
    return {"session": str(args.out), "robot": session.robot, "runs": runs}
