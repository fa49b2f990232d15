"""`shoecal plan ROBOT.yaml`: plan the motions of a self-calibration and check them."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from rich.console import Console

from shoecal_core.commands.arguments import add_planning, planner_settings
from shoecal_core.commands.progress import shown_progress
from shoecal_core.errors import FileError
from shoecal_core.files import atomic_write
from shoecal_core.model.robot_file import load_robot
from shoecal_core.planning.check import check_motion
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.planner import MENU, Planner
from shoecal_core.planning.supports import draw_supports
from shoecal_core.sensing.shoe import load_shoe
from shoecal_core.workspace import config_dir


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare its arguments."""
    parser.add_argument("robot", type=Path, help="robot file")
    parser.add_argument("--shoe", type=Path, help="shoe file (default: the NAO's shoe)")
    parser.add_argument("--motion", choices=sorted(MENU), default="landmarks")
    parser.add_argument("--out", type=Path, required=True, help="folder for the motions")
    add_planning(parser)


def run(args: argparse.Namespace, console: Console) -> Mapping[str, object]:
    """Plan each motion, check it by an independent computation, write it as CSV."""
    settings = planner_settings(args)
    shoe = load_shoe(args.shoe or config_dir() / "shoes" / "nao_shoe.yaml")
    robot = load_robot(args.robot, shoe)
    supports = draw_supports(robot, shoe, settings, settings.supports, args.seed)
    planner = Planner(robot, settings)
    _make_folder(args.out)
    rows: list[dict[str, object]] = []
    with shown_progress() as progress:
        for index, support in enumerate(supports):
            progress(f"planning {index + 1} of {len(supports)}", index / len(supports))
            begin = time.perf_counter()
            motion = planner.plan(support, args.motion)
            seconds = time.perf_counter() - begin
            file = args.out / f"motion_{index + 1:03d}.csv"
            atomic_write(file, _csv(motion))
            findings = check_motion(planner.legs, motion, settings).findings
            rows.append(
                {
                    "file": file.name,
                    "support": [support.dx, support.dy, support.dtheta],
                    "duration_s": motion.duration,
                    "planning_s": seconds,
                    "landmark_distance_mm": (1e3 * motion.path.nearest).tolist(),
                    "worst": {
                        found.constraint: {
                            "value": found.value,
                            "limit": found.limit,
                            "unit": found.unit,
                        }
                        for found in findings
                    },
                }
            )
            console.print(
                f"{file}: {motion.duration:.1f} s, landmarks within "
                f"{1e3 * float(np.max(motion.path.nearest)):.1f} mm, planned in {seconds:.1f} s"
            )
    figures: dict[str, object] = {"robot": robot.name, "seed": args.seed, "motions": rows}
    atomic_write(args.out / "plan.json", json.dumps(figures, indent=1, allow_nan=False) + "\n")
    return figures


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
