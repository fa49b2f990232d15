"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import TypeVar

from shoecal_core.cli.suggestions import nearest
from shoecal_core.errors import FileMissingError, FileTakenError, ShoecalError
from shoecal_core.file_kinds import DECIMAL_POINT
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.named import NAMED, PAPER_DOC, named_supports
from shoecal_core.progress import Progress
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import shoe_file_of
from shoecal_core.settings import SettingError, Settings, load_settings
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.workspace import config_dir

S = TypeVar("S", bound=Settings)
STANDARD_SET = "standard"
"""Names the standard set of motions."""


def run_numbers(text: str) -> tuple[int, ...]:
    """Run numbers separated by commas: `1,2,5`."""
    try:
        numbers = tuple(int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}': expected run numbers separated by commas, for example 1,2,5"
        ) from None
    if len(set(numbers)) < len(numbers):
        raise argparse.ArgumentTypeError(f"'{text}': name each run once")
    return numbers


def motion_names(text: str) -> tuple[str, ...]:
    """Motions of the catalogue separated by commas, or the name of the standard set alone."""
    names = tuple(text.split(","))
    if names == (STANDARD_SET,):
        return names
    for name in names:
        if name not in MOTION_KINDS:
            raise argparse.ArgumentTypeError(
                f"'{name}': expected '{STANDARD_SET}' alone, or motions separated by commas, of: "
                f"{', '.join(MOTION_KINDS)}{nearest(name, (STANDARD_SET, *MOTION_KINDS))}"
            )
    return names


def seed_number(text: str) -> int:
    """A seed: a whole number that is not negative."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"'{text}': expected a whole number, 0 or more")
    return int(text)


def rate_hz(text: str) -> float:
    """A rate of sampling."""
    try:
        rate = float(text)
    except ValueError:
        rate = float("nan")
    if not 1.0 <= rate <= 1e4:
        raise argparse.ArgumentTypeError(f"'{text}': expected 1 to 10000 Hz")
    return rate


def require_folder(path: Path) -> None:
    """Refuse, before any work, a file whose folder does not exist, or that is a folder itself."""
    if path.is_dir():
        raise FileTakenError(path, "is a folder; name a file")
    folder = path.absolute().parent
    if not folder.is_dir():
        raise FileMissingError(folder, f"does not exist; make it first, for {path.name}")


def add_settings(parser: argparse.ArgumentParser, meant: str) -> None:
    """Declare where settings are read from; `meant` names those that a command reads."""
    parser.add_argument(
        "--settings",
        type=Path,
        metavar="FILE",
        help=f"parameter file of the calibrator node, for its {meant}",
    )


def settings_of(cls: type[S], file: Path | None, section: str) -> S:
    """A section of the calibrator's parameter file; the usual ones where no file is named."""
    return cls() if file is None else load_settings(cls, file, "calibrator", section)


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


def add_weight(parser: argparse.ArgumentParser) -> None:
    """`--weight-kg`."""
    parser.add_argument(
        "--weight-kg",
        type=weight_kg,
        metavar="KG",
        help="weight of the robot with its shoes, in place of the robot file's",
    )


def add_rezero(parser: argparse.ArgumentParser) -> None:
    """`--rezero`."""
    parser.add_argument(
        "--rezero",
        action="store_true",
        help="judge each run with its own zeros, taken where a foot hangs in the air",
    )


def weight_kg(text: str) -> float:
    """A weight."""
    try:
        weight = float(text)
    except ValueError:
        weight = float("nan")
    if not 0.1 <= weight <= 1000.0:
        cure = f": {DECIMAL_POINT}" if "," in text else ""
        cure = cure or (": give kg, not grams" if weight > 1000.0 else "")
        raise argparse.ArgumentTypeError(f"'{text}': expected a weight of 0.1 to 1000 kg{cure}")
    return weight


def add_force(parser: argparse.ArgumentParser) -> None:
    """`--force`, of recordings."""
    parser.add_argument(
        "--force",
        action="store_true",
        help="read runs though the session's robot or shoe file was changed since",
    )


def add_json(parser: argparse.ArgumentParser) -> None:
    """`--json` of a subcommand's own parser; the command's has it already."""
    parser.add_argument(
        "--json",
        type=Path,
        metavar="FILE",
        # The command's parser has stored a value by then; a default here would undo it.
        default=argparse.SUPPRESS,
        help="also write the figures as JSON",
    )


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


def add_shoe(parser: argparse.ArgumentParser) -> None:
    """`--shoe`."""
    parser.add_argument(
        "--shoe",
        type=Path,
        metavar="FILE",
        help="shoe file (default: ROBOT_shoe.yaml in ../shoes or next to ROBOT.yaml)",
    )


def shoe_file(args: argparse.Namespace, robot: Path) -> Path:
    """The file of `--shoe`, else the one that belongs to the robot's file."""
    return shoe_file_of(robot) if args.shoe is None else Path(args.shoe)


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
