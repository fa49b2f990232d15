"""How long planning takes, how near it comes, and how far from every limit it stays.

    python benchmarks/planner.py                          # the NAO, seeds 1 to 4
    python benchmarks/planner.py ROBOT.yaml SHOE.yaml --solver ipopt --seeds 2

Draws the double supports of each seed, plans a motion in each and checks it independently.
"""

from __future__ import annotations

import argparse
import dataclasses
import time
from pathlib import Path

import numpy as np

from shoecal_core.model.robot_file import load_robot
from shoecal_core.planning.check import check_motion
from shoecal_core.planning.findings import Finding
from shoecal_core.planning.menu import MENU
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import SOLVERS, PlannerSettings
from shoecal_core.planning.supports import draw_supports
from shoecal_core.sensing.shoe import load_shoe
from shoecal_core.workspace import config_dir


def main() -> None:
    arguments = parse()
    shoe = load_shoe(arguments.shoe)
    robot = load_robot(arguments.robot, shoe)
    settings = dataclasses.replace(PlannerSettings(), solver=arguments.solver)
    begin = time.process_time()
    planner = Planner(robot, settings)
    print(f"{robot.name}, {arguments.solver}: compiled in {time.process_time() - begin:.1f} s CPU")
    print(" seed |     dx     dy  dtheta | CPU s  solves  ms each | motion s | nearest mm")
    worst: dict[str, Finding] = {}
    totals: list[float] = []
    nearest: list[float] = []
    for seed in range(1, arguments.seeds + 1):
        begin = time.process_time()
        supports = draw_supports(robot, shoe, settings, settings.supports, seed)
        drawn = time.process_time() - begin
        for support in supports:
            begin = time.process_time()
            motion = planner.plan(support, arguments.motion)
            totals.append(time.process_time() - begin)
            path = motion.path
            nearest.extend(path.nearest)
            print(
                f"{seed:5d} | {support.dx:6.3f} {support.dy:6.3f} {support.dtheta:7.3f} "
                f"| {totals[-1]:5.2f} {len(path.statuses):7d} {1e3 * path.solve_times.mean():9.1f} "
                f"| {motion.duration:8.1f} | {' '.join(f'{1e3 * d:.1f}' for d in path.nearest)}"
            )
            for finding in check_motion(planner.legs, motion, settings).findings:
                before = worst.get(finding.constraint)
                if before is None or finding.excess > before.excess:
                    worst[finding.constraint] = finding
        print(f"{seed:5d} | drawn in {drawn:.1f} s CPU")
    reached = np.mean(np.array(nearest) < settings.landmark_radius)
    print(
        f"CPU a motion: median {np.median(totals):.2f} s, worst {max(totals):.2f} s; "
        f"{100.0 * reached:.0f} % of {len(nearest)} targets reached"
    )
    for finding in worst.values():
        print(f"  {'kept' if finding.kept else 'VIOLATED'}: {finding}")


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    config = config_dir()
    parser.add_argument("robot", nargs="?", type=Path, default=config / "robots/nao.yaml")
    parser.add_argument("shoe", nargs="?", type=Path, default=config / "shoes/nao_shoe.yaml")
    parser.add_argument("--solver", choices=SOLVERS, default=SOLVERS[0])
    parser.add_argument("--motion", choices=list(MENU), default="landmarks")
    parser.add_argument("--seeds", type=int, default=4)
    return parser.parse_args()


if __name__ == "__main__":
    main()
