"""`shoecal plan ROBOT.yaml`: plan the motions of a self-calibration and check them."""

from __future__ import annotations

import argparse
import json
import re
import time
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console

from shoecal_core.cli.arguments import add_shoe, refuse_exchanged, shoe_file
from shoecal_core.cli.planning_arguments import add_planning, chosen_supports, planner_settings
from shoecal_core.cli.progress import shown_progress
from shoecal_core.cli.prose import say
from shoecal_core.errors import FileTakenError, PartialError, ShoecalError
from shoecal_core.files import atomic_write, make_folder, system_error
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.identifiability import (
    Identifiability,
    identifiability,
    total_information,
)
from shoecal_core.report.plan.content import PlannedMotion
from shoecal_core.report.plan.report import PAGE, Unplanned, picture_name, write_plan
from shoecal_core.report.weak_table import weak_lines
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe

PLAN = "plan.json"
_OWN = re.compile(r"motion_\d{3,}\.(csv|svg)|plan\.html")
"""Files that a plan may name; anything else is not ours to remove."""


class PlanFolder:
    """A folder that a plan is written into; made where there is none.

    Raises:
        FileError: when it cannot be made.
    """

    def __init__(self, folder: Path) -> None:
        make_folder(folder)
        self._folder = folder
        self._earlier = _named(_read(folder / PLAN))

    def replace(self, plan: Mapping[str, object]) -> None:
        """Write `plan.json`; files that only the earlier one names are removed before."""
        for name in sorted(self._earlier - _named(plan)):
            try:
                (self._folder / name).unlink(missing_ok=True)
            except OSError as error:
                problem = "is of an earlier plan and cannot be removed"
                raise system_error(self._folder / name, error, problem, "remove it") from error
        atomic_write(self._folder / PLAN, json.dumps(plan, indent=1, allow_nan=False) + "\n")


def _read(file: Path) -> object:
    """Nothing where there is no plan that can be read."""
    try:
        return json.loads(file.read_bytes())
    except (OSError, ValueError):
        return None


def _named(plan: object) -> set[str]:
    """The plan's own files among all that it names."""
    if not isinstance(plan, Mapping):
        return set()
    rows = plan.get("motions")
    named = [plan.get("page")]
    for row in rows if isinstance(rows, list) else ():
        if isinstance(row, Mapping):
            named += [row.get("file"), row.get("picture")]
    return {name for name in named if isinstance(name, str) and _OWN.fullmatch(name)}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("robot", type=Path, help="robot file")
    add_shoe(parser)
    parser.add_argument(
        "--out", type=Path, metavar="DIR", required=True, help="folder for the motions"
    )
    add_planning(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Plan each motion, check it by an independent computation, write and draw it."""
    settings = planner_settings(args)
    if args.shoe is not None:
        refuse_exchanged(args.robot, args.shoe)
    file = shoe_file(args, args.robot)
    shoe = load_shoe(file)
    robot = load_robot(args.robot, shoe)
    say(console, f"{args.robot} with {file}")
    if args.out.exists() and not args.out.is_dir():
        raise FileTakenError(args.out, "is a file; name a folder")
    with shown_progress() as progress:
        supports = chosen_supports(args, robot, shoe, settings, progress)
        planner = Planner(robot, settings)
        earlier = PlanFolder(args.out)
        plan = _Plan(args, console)
        for index, support in enumerate(supports):
            progress(f"planning {index + 1} of {len(supports)}", index / len(supports))
            plan.add(planner, support, index + 1)
        forecast: dict[str, object] | None = None
        if plan.motions:
            known = _known(robot, shoe, plan, settings, console)
            forecast = {"all": known.to_json()}
            progress("drawing what was planned", 1.0)
            write_plan(args.out, plan.motions, plan.unplanned, known)
    if plan.motions:
        say(console, f"{args.out / PAGE}: pictures and animations of all motions")
    figures: dict[str, object] = {
        "robot": robot.name,
        "shoe": shoe.name,
        "seed": args.seed,
        "page": PAGE if plan.motions else None,
        "motions": plan.rows,
        "unplanned": [_unplanned_row(one) for one in plan.unplanned],
        "forecast": forecast,
    }
    earlier.replace(figures)
    if plan.unplanned:
        raise PartialError(
            f"{len(plan.unplanned)} of {len(supports)} double supports could not be planned; all "
            f"else stands in {args.out}",
            figures,
        )
    return figures


class _Plan:
    """Motions as they are planned, written and listed, and those that could not be.

    Attributes:
        motions, numbers, rows: of each that was planned.
        unplanned: the others.
    """

    def __init__(self, args: argparse.Namespace, console: Console) -> None:
        self.motions: list[PlannedMotion] = []
        self.numbers: list[int] = []
        self.unplanned: list[Unplanned] = []
        self.rows: list[dict[str, object]] = []
        self._kind, self._folder, self._console = args.motion, args.out, console

    def add(self, planner: Planner, support: DoubleSupport, number: int) -> None:
        """Plan one more; if it fails this is reported, and the others are still planned."""
        legs, settings, label = planner.legs, planner.settings, f"motion_{number:03d}"
        begin = time.perf_counter()
        try:
            motion = planner.plan(support, self._kind)
        except ShoecalError as error:
            self.unplanned.append(Unplanned(label, support, str(error)))
            self._say(f"{label}: not planned: {error}")
            return
        seconds = time.perf_counter() - begin
        report = check_motion(legs, motion, settings)
        planned = PlannedMotion(label, legs.robot, motion, report, settings)
        file = self._folder / f"{label}.csv"
        atomic_write(file, _csv(motion))
        self.motions.append(planned)
        self.numbers.append(number)
        self.rows.append(_row(planned, file, seconds))
        self._say(_line(planned, file, seconds))

    def _say(self, line: str) -> None:
        say(self._console, line)


def _unplanned_row(one: Unplanned) -> dict[str, object]:
    support = one.support
    place = [support.dx, support.dy, support.dtheta]
    return {"label": one.label, "support": place, "reason": one.reason}


def _line(planned: PlannedMotion, file: Path, seconds: float) -> str:
    """What the terminal shows of one motion."""
    reached = sum(target.reached for target in planned.targets)
    missed = [
        f"{target.number}: {target.off(planned.settings.landmark_radius)}"
        for target in planned.targets
        if not target.reached
    ]
    without = f" ({', '.join(missed)})" if missed else ""
    return (
        f"{file}: {planned.motion.duration:.1f} s, {reached} of {len(planned.targets)} landmarks "
        f"reached{without}, planned in {seconds:.1f} s"
    )


def _row(planned: PlannedMotion, file: Path, seconds: float) -> dict[str, object]:
    motion = planned.motion
    support = motion.support
    return {
        "file": file.name,
        "picture": picture_name(planned),
        "support": [support.dx, support.dy, support.dtheta],
        "duration_s": motion.duration,
        "planning_s": seconds,
        "landmark_distance_mm": [
            1e3 * target.nearest if target.pursued else None for target in planned.targets
        ],
        "worst": {
            found.constraint: {"value": found.value, "limit": found.limit, "unit": found.unit}
            for found in planned.report.findings
        },
    }


def _known(
    robot: Robot, shoe: Shoe, plan: _Plan, settings: PlannerSettings, console: Console
) -> Identifiability:
    """Print and return what a calibration from the planned motions would identify."""
    visits = [planned.motion.visit for planned in plan.motions]
    known = identifiability(robot, shoe, total_information(robot, shoe, visits), settings)
    say(
        console,
        f"a calibration from them would identify {known.rank} of {known.possible} directions",
    )
    for line in weak_lines(known):
        say(console, line)
    return known


def _csv(motion: Motion) -> str:
    """Time [s] and every joint angle [rad], a line a point."""
    lines = [",".join(("time_s", *motion.joint_names))]
    for moment, angles in zip(motion.time, motion.positions, strict=True):
        lines.append(",".join((f"{moment:.3f}", *(f"{angle:.6f}" for angle in angles))))
    return "\n".join(lines) + "\n"
