"""`shoecal import csv|bag|draft`: turn foreign recordings into a session."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console

from shoecal_core.cli.arguments import add_json, add_shoe, require_folder, shoe_file
from shoecal_core.cli.prose import say
from shoecal_core.errors import FileMissingError, FileTakenError, FileUnreadableError
from shoecal_core.files import atomic_write
from shoecal_core.recording.imports.bag_draft import draft_mapping, mapping_text
from shoecal_core.recording.imports.bag_import import import_bags
from shoecal_core.recording.imports.csv_import import import_csv
from shoecal_core.recording.session import Session, require_free
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe

CSV, BAG, DRAFT = "csv", "bag", "draft"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its kinds and their arguments."""
    kinds = parser.add_subparsers(dest="kind", metavar="csv|bag|draft", required=True)
    table = kinds.add_parser(CSV, help="CSV tables, by a mapping file")
    bag = kinds.add_parser(BAG, help="bags of ROS 1 or ROS 2, by a mapping file")
    for kind, meaning in ((table, "columns"), (bag, "topics")):
        kind.add_argument("mapping", type=Path, help=f"YAML file that says what the {meaning} mean")
        kind.add_argument("folder", type=Path, help="where the recordings are; left as it is")
        kind.add_argument(
            "--out", type=Path, metavar="DIR", required=True, help="the session to make"
        )
    draft = kinds.add_parser(DRAFT, help="draft the mapping file of bags from the bags themselves")
    draft.add_argument(
        "bags", type=Path, nargs="+", metavar="BAG",
        help=".bag, .mcap or .db3 file, or a folder of rosbag2; one trial each",
    )  # fmt: skip
    draft.add_argument("--robot", type=Path, required=True, metavar="FILE", help="robot file")
    add_shoe(draft)
    draft.add_argument(
        "--out", type=Path, metavar="FILE", required=True, help="mapping file to make"
    )
    for kind in (table, bag, draft):
        add_json(kind)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Import the recordings, or draft the mapping."""
    if args.kind == DRAFT:
        return _draft(args, console)
    if not args.mapping.exists():
        made = "write one" if args.kind == CSV else "`shoecal import draft` makes one"
        raise FileMissingError(args.mapping, f"does not exist; {made}")
    if args.mapping.is_dir() and args.folder.is_file():
        raise FileUnreadableError(
            args.mapping, f"is a folder, and {args.folder} a file: name the mapping first, then "
            "the folder of the recordings",
        )  # fmt: skip
    require_free(args.out)
    make = import_csv if args.kind == CSV else import_bags
    session = make(args.mapping, args.folder, args.out)
    return _report(session, args.out, console)


def _report(session: Session, out: Path, console: Console) -> Mapping[str, object]:
    entries = session.runs
    say(console, f"{out}: {len(entries)} runs of robot '{session.robot}'")
    for entry in entries:
        for note in entry.info.notes:
            say(console, f"  run {entry.run}: {note}")
    return {
        "session": str(out),
        "robot": session.robot,
        "runs": [
            {"run": entry.run, "motion": entry.info.motion, "notes": list(entry.info.notes)}
            for entry in entries
        ],
    }


def _draft(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    if args.out.exists():
        raise FileTakenError(args.out, "exists already; name another file")
    require_folder(args.out)
    shoe = load_shoe(shoe_file(args, args.robot))
    robot = load_robot(args.robot, shoe)
    draft = draft_mapping(args.bags, robot, shoe)
    text = mapping_text(draft, args.out.absolute().parent, args.robot, robot.urdf, shoe.path)
    atomic_write(args.out, text)
    say(console, f"{args.out}: drafted; check it:")
    for key, match in draft.fields.items():
        topics = ", ".join(match.topics)
        line = f"  {key}: {topics}" if match.chosen else f"  {key}: CHOOSE one of {topics}"
        say(console, line)
        for note in match.notes:
            say(console, f"    {note}")
    for note in draft.notes:
        say(console, f"  {note}")
    folder = args.bags[0].absolute().parent
    say(console, f"Then: shoecal import bag {args.out} {folder} --out SESSION")
    return {
        "mapping": str(args.out),
        "fields": {
            key: {"topics": list(match.topics), "chosen": match.chosen, "notes": list(match.notes)}
            for key, match in draft.fields.items()
        },
        "notes": list(draft.notes),
    }
