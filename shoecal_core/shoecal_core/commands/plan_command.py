"""`shoecal plan ROBOT.yaml`: plan the motions of a self-calibration and check them."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from shoecal_core.commands.arguments import add_planning, chosen_supports, planner_settings
from shoecal_core.commands.forecast_lines import addition_lines, forecast_table, weak_lines
from shoecal_core.commands.progress import shown_progress
from shoecal_core.errors import FileError
from shoecal_core.files import atomic_write
from shoecal_core.model.robot import Robot
from shoecal_core.model.robot_file import load_robot
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import trained_supports
from shoecal_core.planning.supports.forecast import (
    best_additions,
    forecast_visits,
    total_information,
    worst_part,
)
from shoecal_core.planning.supports.observability import Visit
from shoecal_core.report.plan_content import PlannedMotion
from shoecal_core.report.plan_report import PAGE, picture_name, write_plan
from shoecal_core.sensing.shoe import Shoe, load_shoe
from shoecal_core.workspace import config_dir

ADDITIONS = 2
"""Double supports that are recommended beyond the planned ones."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("robot", type=Path, help="robot file")
    parser.add_argument("--shoe", type=Path, help="shoe file (default: the NAO's shoe)")
    parser.add_argument("--out", type=Path, required=True, help="folder for the motions")
    add_planning(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Plan each motion, check it by an independent computation, write and draw it; forecast."""
    settings = planner_settings(args)
    shoe = load_shoe(args.shoe or config_dir() / "shoes" / "nao_shoe.yaml")
    robot = load_robot(args.robot, shoe)
    supports = chosen_supports(args, robot, shoe, settings)
    planner = Planner(robot, settings)
    _make_folder(args.out)
    rows: list[dict[str, object]] = []
    motions: list[PlannedMotion] = []
    with shown_progress() as progress:
        for index, support in enumerate(supports):
            progress(f"planning {index + 1} of {len(supports)}", index / len(supports))
            begin = time.perf_counter()
            motion = planner.plan(support, args.motion)
            seconds = time.perf_counter() - begin
            report = check_motion(planner.legs, motion, settings)
            planned = PlannedMotion(f"motion_{index + 1:03d}", robot, motion, report, settings)
            file = args.out / f"{planned.label}.csv"
            atomic_write(file, _csv(motion))
            motions.append(planned)
            rows.append(_row(planned, file, seconds))
            console.print(_line(planned, file, seconds))
        progress("drawing what was planned", 1.0)
        write_plan(args.out, motions)
        progress("looking for the best double supports to add", 1.0)
        told = _forecast(robot, shoe, [planned.motion for planned in motions], settings, console)
    console.print(f"{args.out / PAGE}: pictures and animations of all motions")
    figures: dict[str, object] = {
        "robot": robot.name,
        "seed": args.seed,
        "page": PAGE,
        "motions": rows,
        "forecast": told,
    }
    atomic_write(args.out / "plan.json", json.dumps(figures, indent=1, allow_nan=False) + "\n")
    return figures


def _line(planned: PlannedMotion, file: Path, seconds: float) -> str:
    """What the terminal tells of one motion."""
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


def _forecast(
    robot: Robot,
    shoe: Shoe,
    motions: Sequence[Motion],
    settings: PlannerSettings,
    console: Console,
) -> dict[str, object]:
    """Print and return what the planned motions will tell, and what more would."""
    visits = [Visit.of(motion, settings) for motion in motions]
    whole = forecast_visits(robot, shoe, visits, settings)
    rows = [(f"all {len(visits)}", whole)]
    told: dict[str, object] = {"all": whole.to_json()}
    trained = trained_supports(len(visits), settings)
    if trained < len(visits):
        indices, worst = worst_part(robot, shoe, visits, trained, settings)
        runs = [index + 1 for index in indices]
        rows.append((f"at worst {trained} of them ({', '.join(map(str, runs))})", worst))
        told["worst_training"] = {"motions": runs, **worst.to_json()}
    known = total_information(robot, shoe, visits, settings)
    additions = best_additions(robot, shoe, known, settings, ADDITIONS)
    told["best_additions"] = [addition.to_json() for addition in additions]
    console.print(forecast_table(rows))
    for line in (*weak_lines(rows[-1][1]), *addition_lines(whole, additions)):
        console.print(line)
    return told


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(folder, f"cannot be made ({error.strerror})") from error


def _csv(motion: Motion) -> str:
    """Time [s] and every joint angle [rad], a line a point."""
    lines = [",".join(("time_s", *motion.joint_names))]
    for moment, angles in zip(motion.time, motion.positions, strict=True):
        lines.append(",".join((f"{moment:.3f}", *(f"{angle:.6f}" for angle in angles))))
    return "\n".join(lines) + "\n"
