"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path

from shoecal_core.errors import ShoecalError
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.settings import SettingError, load_settings
from shoecal_core.workspace import config_dir


def run_numbers(text: str) -> tuple[int, ...]:
    """Run numbers separated by commas: `1,2,5`."""
    try:
        return tuple(int(part) for part in text.split(",") if part.strip())
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}': expected run numbers separated by commas, for example 1,2,5"
        ) from None


def add_sets(parser: argparse.ArgumentParser) -> None:
    """`--train` and `--test`."""
    parser.add_argument(
        "--train",
        type=run_numbers,
        default=(),
        metavar="R,…",
        help="runs to fit (default: as the session marks them, else all)",
    )
    parser.add_argument(
        "--test", type=run_numbers, default=(), metavar="R,…", help="runs kept for the test"
    )


def add_planning(parser: argparse.ArgumentParser) -> None:
    """`--supports`, `--seed` and `--settings` of planning."""
    parser.add_argument("--supports", type=int, help="double supports (default: as configured)")
    parser.add_argument("--seed", type=int, default=1, help="draws whatever is random")
    parser.add_argument("--settings", type=Path, help="parameter file of the planner node")


def planner_settings(args: argparse.Namespace) -> PlannerSettings:
    """Planning settings of the file named, else of the configuration folder."""
    path = args.settings or config_dir() / "nodes" / "planner.yaml"
    settings = load_settings(PlannerSettings, path, "planner", "planning")
    if args.supports is None:
        return settings
    try:
        return dataclasses.replace(settings, supports=args.supports)
    except SettingError as error:
        raise ShoecalError(f"--{error}") from error
