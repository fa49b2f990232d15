"""Arguments that several commands share."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TypeVar

from shoecal_core.errors import FileMissingError, FileTakenError, ShoecalError
from shoecal_core.file_kinds import DECIMAL_POINT, ROBOT_FILE, SHOE_FILE
from shoecal_core.files import file_kind
from shoecal_core.parameter_file import load_settings
from shoecal_core.robot.robot_file import shoe_file_of
from shoecal_core.settings import Settings

S = TypeVar("S", bound=Settings)


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


def seed_number(text: str) -> int:
    """A seed: a whole number that is not negative."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"'{text}': expected a whole number, 0 or more")
    return int(text)


def _number(text: str) -> float:
    """NaN where the text is none: it lies in no range."""
    try:
        return float(text)
    except ValueError:
        return float("nan")


def rate_hz(text: str) -> float:
    """A rate of sampling."""
    rate = _number(text)
    if not 1.0 <= rate <= 1e4:
        raise argparse.ArgumentTypeError(f"'{text}': expected 1 to 10000 Hz")
    return rate


def length_mm(text: str) -> float:
    """A length in millimetres."""
    length = _number(text)
    if not 0.1 <= length <= 100.0:
        raise argparse.ArgumentTypeError(f"'{text}': expected 0.1 to 100 mm")
    return length


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
    weight = _number(text)
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


def add_shoe(parser: argparse.ArgumentParser) -> None:
    """`--shoe`."""
    parser.add_argument(
        "--shoe",
        type=Path,
        metavar="FILE",
        help="shoe file (default: ROBOT_shoe.yaml in ../shoes or next to ROBOT.yaml)",
    )


def refuse_exchanged(robot: Path, shoe: Path) -> None:
    """Refuse a shoe file in place of the robot file, and the robot file in place of the shoe's."""
    given = [file_kind(path) for path in (robot, shoe)]
    if given == [SHOE_FILE, ROBOT_FILE]:
        raise ShoecalError(f"{robot} is the shoe file and {shoe} the robot file: exchange the two")


def shoe_file(args: argparse.Namespace, robot: Path) -> Path:
    """The file of `--shoe`, else the one that belongs to the robot's file."""
    return shoe_file_of(robot) if args.shoe is None else Path(args.shoe)
