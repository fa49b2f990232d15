"""`shoecal simulate ROBOT.yaml SHOE.yaml`: a session of the simulated robot, without ROS."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from shoecal_core.cli.arguments import rate_hz, refuse_exchanged, seed_number
from shoecal_core.cli.planning_arguments import (
    add_planning,
    chosen_supports,
    motion_names,
    planner_settings,
)
from shoecal_core.cli.progress import shown_progress
from shoecal_core.cli.prose import say
from shoecal_core.planning.motion_sets import MOTION_SETS, PlannedRun, listed_runs, set_runs
from shoecal_core.recording.session import require_free
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.sampled_robot import draw
from shoecal_core.workflows.simulated_session import SimulationPlan, simulate_session
from shoecal_core.workspace import config_dir


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("robot", type=Path, help="robot file")
    parser.add_argument("shoe", type=Path, help="shoe file")
    parser.add_argument(
        "--reality", type=Path, metavar="FILE", help="changes to the default simulated reality"
    )
    parser.add_argument(
        "--own-steps",
        action="store_true",
        help="walk from one double support to the next instead of being placed there",
    )
    parser.add_argument("--rate", type=rate_hz, default=100.0, help="samples a second (Hz)")
    parser.add_argument(
        "--robot-seed",
        type=seed_number,
        help="draws robot and cells (default: the seed): the same robot again under another seed",
    )
    parser.add_argument(
        "--motions",
        type=motion_names,
        metavar="M,…",
        help="one run of each motion, in the double supports in turn (instead of --motion); or a "
        "set, marked to train and to test: "
        + "; ".join(f"{name} ({one.doc})" for name, one in MOTION_SETS.items()),
    )
    parser.add_argument("--out", type=Path, metavar="DIR", required=True, help="session to make")
    add_planning(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Simulate and record."""
    require_free(args.out)
    settings = planner_settings(args)
    if args.own_steps:
        settings = dataclasses.replace(settings, one_foot=True)
    refuse_exchanged(args.robot, args.shoe)
    shoe = load_shoe(args.shoe)
    robot = load_robot(args.robot, shoe)
    reality = load_reality(config_dir() / "realities" / "default.yaml", args.reality)
    robot_seed = args.seed if args.robot_seed is None else args.robot_seed
    draw(reality, robot, shoe, robot_seed)  # refuses names that there are not, before any search
    with shown_progress() as progress:
        plan = SimulationPlan(
            robot=robot,
            shoe=shoe,
            reality=reality,
            settings=settings,
            runs=_runs(args, robot, chosen_supports(args, robot, shoe, settings, progress)),
            rate=args.rate,
            seed=args.seed,
            robot_seed=robot_seed,
            own_steps=args.own_steps,
            drawn=args.stance is None,
        )
        session = simulate_session(plan, args.out, progress)
    runs = [
        {
            "run": entry.run,
            "support": [support.dx, support.dy, support.dtheta],
            "motion": entry.info.motion,
            "set": entry.hint,
        }
        for entry in session.runs
        if (support := entry.info.support) is not None
    ]
    say(console, f"{args.out}: {len(runs)} simulated runs")
    return {
        "session": str(args.out),
        "seed": plan.seed,
        "robot_seed": plan.robot_seed,
        "runs": runs,
    }


def _runs(
    args: argparse.Namespace, robot: Robot, supports: Sequence[DoubleSupport]
) -> Sequence[PlannedRun]:
    """What to do where: `--motions`, else the one motion in each double support."""
    if args.motions and args.motions[0] in MOTION_SETS:
        return set_runs(args.motions[0], supports, robot.neutral)
    return listed_runs(supports, args.motions or [args.motion] * len(supports))
