"""Arguments of the commands that plan motions."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Mapping
from pathlib import Path

from shoecal_core.cli.arguments import seed_number
from shoecal_core.cli.suggestions import nearest
from shoecal_core.errors import ShoecalError
from shoecal_core.parameter_file import load_settings
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.planning.motion_sets import MOTION_SETS
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.named import NAMED, PAPER_DOC, named_supports
from shoecal_core.progress import Progress
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.settings import SettingError
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.workspace import config_dir


def motion_names(text: str) -> tuple[str, ...]:
    """Motions of the catalogue separated by commas, or the name of a set of motions alone."""
    names = tuple(text.split(","))
    if len(names) == 1 and names[0] in MOTION_SETS:
        return names
    for name in names:
        if name not in MOTION_KINDS:
            raise argparse.ArgumentTypeError(
                f"'{name}': expected a set ({', '.join(MOTION_SETS)}) alone, or motions separated "
                f"by commas, of: {', '.join(MOTION_KINDS)}"
                f"{nearest(name, (*MOTION_SETS, *MOTION_KINDS))}"
            )
    return names


def add_planning(parser: argparse.ArgumentParser) -> None:
    """`--motion`, `--supports` or `--stance`, `--seed` and `--settings` of planning."""
    parser.add_argument(
        "--motion",
        choices=list(MOTION_KINDS),
        default="landmarks",
        metavar="NAME",
        help=_listed("what to do", {name: kind.doc for name, kind in MOTION_KINDS.items()}),
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--supports", type=int, help="double supports drawn (default: as configured)"
    )
    where.add_argument(
        "--stance",
        nargs="+",
        choices=[*NAMED, "paper"],
        metavar="NAME",
        help=_listed(
            "double supports by name",
            {name: at.doc for name, at in NAMED.items()} | {"paper": PAPER_DOC},
        ),
    )
    parser.add_argument("--seed", type=seed_number, default=1, help="draws whatever is random")
    parser.add_argument(
        "--settings", type=Path, metavar="FILE", help="parameter file of the planner node"
    )


def _listed(what: str, choices: Mapping[str, str]) -> str:
    return f"{what}: " + "; ".join(f"{name} ({doc})" for name, doc in choices.items())


def chosen_supports(
    args: argparse.Namespace,
    robot: Robot,
    shoe: Shoe,
    settings: PlannerSettings,
    progress: Progress,
) -> list[DoubleSupport]:
    """The double supports of `--stance`, else as many as the settings say, drawn.

    Args:
        args: of the command.
        robot, shoe, settings: who visits them.
        progress: called during the search.
    """
    progress("looking for double supports", 0.0)
    if args.stance is None:

        def report(tried: int, most: int) -> None:
            if tried:
                progress(f"looking for double supports, {tried} of at most {most} tried", 0.0)

        return draw_supports(robot, shoe, settings, settings.supports, args.seed, report)
    feasible = Feasible(robot, settings)
    return [support for name in args.stance for support in named_supports(name, feasible)]


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
