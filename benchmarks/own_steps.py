"""Does the robot walk from support to support by its own steps, in the physics, without a fall?

    .venv/bin/python benchmarks/own_steps.py [--supports 50] [--seeds 6] [--again]

Each seed draws a robot of the default reality and double supports of its range. It is placed in
the first one only, and steps to all others. Writes the table of docs/evidence/own-steps.md and the
key `own_steps` of out/bench.json. A seed whose result stands in `--out` is not run again, so an
interrupted run goes on.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import json
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
import shapely

from pages import ROOT, markdown, record, write_section
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.steps import StepError, Stepper
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.robot import RobotFellError, SimulatedRobot
from shoecal_core.simulation.sampled_robot import draw
from shoecal_core.workflows.simulated_session import walk
from shoecal_core.workspace import config_dir

ROBOTS = {"nao": "nao_shoe", "wren": "wren_shoe"}
OUT = ROOT / "out" / "own_steps"
PAGE = ROOT / "docs" / "evidence" / "own-steps.md"
PROCESSES = 2
_MIDDLE = 0.4, 0.6
"""Part of the way of a carried foot in which it is as high as it shall be."""


@dataclass
class Walked:
    """One robot's way, lengths in mm and times in s.

    Attributes:
        robot, seed: who went.
        asked: double supports to go to.
        refused: of them, before the robot moved: no step leads there within load and tilt.
        reached: of the others, as the encoders told.
        fell: whether it fell.
        reason: why it did not reach one, empty where it did.
        steps: needed for each support.
        duration: of each step.
        feet_error, yaw_error: true feet from each support reached; the latter in rad.
        gap: least true one between the feet's outlines.
        height: least true one of the carried foot's lowest corner in the middle of its way.
        tilt: greatest true one of the torso [rad].
    """

    robot: str
    seed: int
    asked: int
    refused: int = 0
    reached: int = 0
    fell: bool = False
    reason: str = ""
    steps: list[int] = field(default_factory=list)
    duration: list[float] = field(default_factory=list)
    feet_error: list[tuple[float, float]] = field(default_factory=list)
    yaw_error: list[float] = field(default_factory=list)
    gap: float = float("inf")
    height: float = float("inf")
    tilt: float = 0.0


def robot_of(name: str) -> tuple[Robot, Callable[[int], SimulatedRobot]]:
    """A robot as described, and the ones that seeds draw."""
    config = config_dir()
    shoe = load_shoe(config / "shoes" / f"{ROBOTS[name]}.yaml")
    robot = load_robot(config / "robots" / f"{name}.yaml", shoe)
    reality = load_reality(config / "realities" / "default.yaml")

    def simulated(seed: int) -> SimulatedRobot:
        drawn = draw(reality, robot, shoe, seed)
        return SimulatedRobot(robot, shoe, drawn, np.random.default_rng([seed, 1]))

    return robot, simulated


class Witness:
    """Looks at the true robot while it walks."""

    def __init__(self, sim: SimulatedRobot, walked: Walked) -> None:
        self._sim, self._walked = sim, walked

    def __call__(self, motion: Motion, since: float) -> None:
        """As `walk` tells."""
        snap, walked = self._sim.snapshot(), self._walked
        x, y = snap.base_orientation[:2]
        walked.tilt = max(walked.tilt, float(np.arccos(1.0 - 2.0 * (x * x + y * y))))
        swing = motion.phases[1]
        if _MIDDLE[0] < (since - swing.begin) / (swing.end - swing.begin) < _MIDDLE[1]:
            foot = 1 - swing.support_phase.standing
            outline = self._sim.robot.feet[foot].outline
            flat = np.column_stack([outline, np.zeros(len(outline))])
            corners = snap.sole_position[foot] + flat @ snap.sole_rotation[foot].T
            walked.height = min(walked.height, 1e3 * float(corners[:, 2].min()))
        left, right = (
            shapely.Polygon(position[:2] + foot.outline @ rotation[:2, :2].T)
            for position, rotation, foot in zip(
                snap.sole_position, snap.sole_rotation, self._sim.robot.feet, strict=True
            )
        )
        walked.gap = min(walked.gap, 1e3 * float(left.distance(right)))

    def arrived(self, goal: DoubleSupport) -> None:
        """Note where the feet truly stand."""
        snap = self._sim.snapshot()
        turn = snap.sole_rotation[0].T @ snap.sole_rotation[1]
        way = snap.sole_rotation[0].T @ (snap.sole_position[1] - snap.sole_position[0])
        off = 1e3 * (way[:2] - goal.translation)
        yaw = float(np.arctan2(turn[1, 0], turn[0, 0]))
        self._walked.feet_error.append((float(off[0]), float(off[1])))
        self._walked.yaw_error.append(yaw - goal.dtheta)


def go(supports: int, who: tuple[str, int]) -> Walked:
    """Let one robot walk."""
    name, seed = who
    robot, simulated = robot_of(name)
    settings = PlannerSettings(one_foot=True)
    planner = Planner(robot, settings)
    drawn = Feasible(robot, settings).draw(np.random.default_rng([seed, 2]))
    start, *goals = itertools.islice(drawn, 1 + supports)
    stepper, sim = Stepper(planner), simulated(seed)
    sim.place(planner.stance(start))
    walked = Walked(name, seed, len(goals))
    witness = Witness(sim, walked)
    try:
        for goal in goals:
            walked_until = sim.time
            begin = time.perf_counter()
            try:
                motions = walk(sim, stepper, goal, witness)
            except StepError as error:
                if sim.time > walked_until:
                    raise
                walked.refused += 1
                print(f"{name} {seed}: {error}", flush=True)
                continue
            witness.arrived(goal)
            walked.reached += 1
            walked.steps.append(len(motions))
            walked.duration += [motion.duration for motion in motions]
            _tell(walked, goal, time.perf_counter() - begin)
    except RobotFellError as error:
        walked.fell, walked.reason = True, str(error)
    except ShoecalError as error:
        walked.reason = str(error)
    if walked.reason:
        print(f"{name} {seed}: {walked.reason}", flush=True)
    return walked


def _tell(walked: Walked, goal: DoubleSupport, seconds: float) -> None:
    x, y = walked.feet_error[-1]
    print(
        f"{walked.robot} {walked.seed}: {walked.reached} of {walked.asked}, {walked.steps[-1]} "
        f"step(s) to {goal}, true feet off by {x:.1f}, {y:.1f} mm, {seconds:.1f} s",
        flush=True,
    )


def kept(out: Path, supports: int, again: bool, who: tuple[str, int]) -> Walked:
    """What stands in a file, else what is measured now and written there."""
    file = out / f"{who[0]}_{who[1]:02d}_{supports}.json"
    if again or not file.is_file():
        walked = go(supports, who)
        out.mkdir(parents=True, exist_ok=True)
        atomic_write(file, json.dumps(dataclasses.asdict(walked)) + "\n")
        return walked
    return Walked(**json.loads(file.read_text()))


def figures(walks: Sequence[Walked]) -> dict[str, str]:
    """All walks of one robot together, as the table has them."""
    asked, refused, reached = (
        sum(getattr(walked, name) for walked in walks) for name in ("asked", "refused", "reached")
    )
    steps = [count for walked in walks for count in walked.steps]
    lasting = [seconds for walked in walks for seconds in walked.duration]
    off = np.array([one for walked in walks for one in walked.feet_error])
    yaw = np.abs([one for walked in walks for one in walked.yaw_error])
    away = np.hypot(*off.T)
    return {
        "robots drawn": f"{len(walks)}",
        "double supports asked for": f"{asked}",
        "of these refused before the robot moved": f"{refused}",
        "reached": f"{reached}",
        "falls": f"{sum(walked.fell for walked in walks)}",
        "steps taken; most for one support": f"{sum(steps)}; {max(steps)}",
        "duration of a step, median (worst) [s]": f"{np.median(lasting):.1f} ({max(lasting):.1f})",
        "true feet from where they should be [mm]": f"{np.median(away):.1f} ({away.max():.1f})",
        "of it narrower, median [mm]": f"{np.median(off[:, 1]):.1f}",
        "the same in yaw [rad]": f"{np.median(yaw):.3f} ({yaw.max():.3f})",
        "least true gap between the feet [mm]": f"{min(walked.gap for walked in walks):.1f}",
        "least true height of the carried foot, 15 planned [mm]": (
            f"{min(walked.height for walked in walks):.1f}"
        ),
        "greatest true tilt of the torso [rad]": f"{max(walked.tilt for walked in walks):.2f}",
    }


def main() -> int:
    """Measure and write; fails when a robot fell or did not arrive where a step was planned."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--supports", type=int, default=50)
    parser.add_argument("--seeds", type=int, default=6)
    parser.add_argument("--robots", nargs="+", choices=list(ROBOTS), default=list(ROBOTS))
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--again", action="store_true", help="measure what stands there too")
    args = parser.parse_args()
    who = [(name, seed) for seed in range(1, args.seeds + 1) for name in args.robots]
    with ProcessPoolExecutor(PROCESSES) as pool:
        walks = list(pool.map(partial(kept, args.out, args.supports, args.again), who))
    measured = {
        name: figures([walked for walked in walks if walked.robot == name]) for name in args.robots
    }
    rows = [
        {"figure": what, **{name: of[what] for name, of in measured.items()}}
        for what in measured[args.robots[0]]
    ]
    record("own_steps", measured)
    write_section("own-steps", markdown(rows), PAGE)
    print(markdown(rows))
    return 0 if all(walked.reached + walked.refused == walked.asked for walked in walks) else 1


if __name__ == "__main__":
    raise SystemExit(main())
