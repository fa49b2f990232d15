"""`shoecal new robot FILE`: files of a robot, its shoes and its simulation from URDF or MJCF."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from shoecal_core.cli.prose import say
from shoecal_core.drafting.draft import draft_robot, prove, relative
from shoecal_core.drafting.mjcf import as_urdf
from shoecal_core.drafting.notes import Note, robot_notes, shoe_notes
from shoecal_core.drafting.simulated import reality_text
from shoecal_core.drafting.soles import SoleSize
from shoecal_core.drafting.text import robot_text, shoe_text
from shoecal_core.errors import FileError, FileTakenError, ShoecalError
from shoecal_core.file_kinds import is_mjcf
from shoecal_core.files import atomic_write, make_folder, read_bytes
from shoecal_core.robot.mjcf import MjcfError

LARGEST_M = 0.5
"""From an ankle to an edge of its sole; more was given in other units."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument(
        "kind", type=_kind, choices=("robot",), metavar="robot", help="what to draft"
    )
    parser.add_argument(
        "urdf", type=Path, metavar="URDF_OR_MJCF",
        help="the robot's URDF, or its MJCF, of which a URDF is made; it is left as it is",
    )  # fmt: skip
    parser.add_argument(
        "-o", "--out", type=Path, metavar="ROBOT.yaml",
        help="robot file to make (default: next to the description, of its name)",
    )  # fmt: skip
    parser.add_argument(
        "--shoe", type=Path, metavar="SHOE.yaml",
        help="shoe file to make (default: ROBOT_shoe.yaml next to the robot file)",
    )  # fmt: skip
    parser.add_argument(
        "--name", dest="robot_name", help="of the robot (default: the robot file's)"
    )
    parser.add_argument(
        "--six-axis",
        action="store_true",
        help="the ankles have six-axis sensors, though the URDF names none",
    )
    parser.add_argument(
        "--sole",
        type=float,
        nargs=5,
        metavar=("BACK", "FRONT", "INNER", "OUTER", "HEIGHT"),
        help="a measured sole, where the URDF has no shape of the feet: its edges from the ankle, "
        "and the ankle's height above the floor (m)",
    )
    parser.add_argument(
        "--mesh-dir", type=Path, metavar="DIR",
        help="folder of the URDF's meshes (default: where the URDF says, else near it)",
    )  # fmt: skip
    parser.add_argument("--force", action="store_true", help="replace files that are there")


def _kind(text: str) -> str:
    """What to draft; a file there is the description, and the kind was left out."""
    if text != "robot":
        raise argparse.ArgumentTypeError(f"'{text}': write 'shoecal new robot {text}'")
    return text


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Draft the files, prove that they load, write them, say what to check."""
    out: Path = args.out or args.urdf.with_suffix(".yaml")
    shoe: Path = args.shoe or out.with_name(f"{out.stem}_shoe.yaml")
    if out.resolve() == shoe.resolve():
        raise ShoecalError(f"{out}: robot file and shoe file cannot be one; name another --shoe")
    reality = out.with_name(f"{out.stem}_reality.yaml")
    text = read_bytes(args.urdf).decode("utf-8", errors="replace")
    converted = as_urdf(args.urdf, f"{out.stem}_meshes") if is_mjcf(text) else None
    urdf = args.urdf if converted is None else out.with_suffix(".urdf")
    for file in (out, shoe, reality, *(() if converted is None else (urdf,))):
        if file.exists() and not args.force:
            problem = "is there already; name another one, or replace it with --force"
            raise FileTakenError(file, problem)
    with tempfile.TemporaryDirectory() as folder:
        read = args.urdf if converted is None else converted.write(Path(folder, urdf.name))
        try:
            draft = draft_robot(
                read,
                args.robot_name or out.stem,
                six_axis=args.six_axis,
                sole=_sole(args.sole),
                meshes=args.mesh_dir,
                keyframes=None if converted is None else converted.keyframes,
            )
            texts = {out: robot_text(draft, relative(urdf, out.parent)), shoe: shoe_text(draft)}
            robot, worn = prove(draft, texts[out], texts[shoe])
        except FileError as error:
            if converted is None:
                raise
            raise MjcfError(args.urdf, error.problem, field=error.field) from error
    texts[reality] = reality_text(robot, worn)
    if converted is not None:
        converted.write(urdf)
    for file, text in texts.items():
        make_folder(file.parent)
        atomic_write(file, text)
    notes = {out: robot_notes(draft), shoe: shoe_notes(draft)}
    if converted is not None:
        notes = {urdf: [*converted.assumed], **notes}
    for file, to_check in notes.items():
        _print_notes(console, file, to_check)
    say(
        console,
        f"{reality}: drafted for a robot of this size\n"
        f"Then: shoecal plan {out} --shoe {shoe} --supports 1 --out out/plan\n"
        f"      shoecal simulate {out} {shoe} --reality {reality} --out out/session\n"
        "      shoecal calibrate out/session --out out/calibration.yaml",
    )
    return {
        "robot": str(out),
        "shoe": str(shoe),
        "reality": str(reality),
        "mass_kg": draft.mass,
        "legs": draft.leg_names,
        "six_axis": draft.six_axis[0] is not None,
        "check": [
            {"file": str(file), "field": note.field, "found": note.found, "check": note.look}
            for file, to_check in notes.items()
            for note in to_check
        ],
    }


def _sole(numbers: Sequence[float] | None) -> SoleSize | None:
    """The sole of `--sole`."""
    if numbers is None:
        return None
    size = SoleSize(*numbers)
    for name, value in zip(("BACK", "FRONT", "INNER", "OUTER", "HEIGHT"), numbers, strict=True):
        if not 0.0 < value < LARGEST_M:
            raise ShoecalError(
                f"--sole: {name} is {value:g}; give it in metres, above 0 and below {LARGEST_M:g}"
            )
    return size


def _print_notes(console: Console, file: Path, notes: Sequence[Note]) -> None:
    say(console, f"{file}: drafted; check, line by line:")
    for note in notes:
        line = f"  {note.field}: {note.found} Check: {note.look}"
        say(console, line)
