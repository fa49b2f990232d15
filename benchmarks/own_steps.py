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
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from pages import ROOT, markdown, record, write_section
from shoecal_core.commands.simulated_walk import walk
from shoecal_core.errors import ShoecalError
from shoecal_core.files import atomic_write
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.model.robot_file import load_robot
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.steps import Stepper
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.sensing.shoe import load_shoe
from shoecal_core.simulation.drawn import draw
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.simulation.robot import RobotFellError, SimulatedRobot
from shoecal_core.workspace import config_dir

FloatArray = NDArray[np.float64]
ROBOTS = {"nao": "nao_shoe", "wren": "wren_shoe"}
OUT = ROOT / "out" / "own_steps"
PAGE = ROOT / "docs" / "evidence" / "own-steps.md"
PROCESSES = 2


@dataclass
class Walked:
    """One robot's way, lengths in mm and times in s.

    Attributes:
        robot, seed: who went.
        asked: double supports to go to.
        reached: of them, as the encoders told.
        fell: whether it fell.
        reason: why it did not reach one, empty where it did.
        steps: needed for each support.
        duration: of each step.
        one_foot: how long one foot carried in each step.
        hottest: of all motors at any time [degC].
        feet_error, yaw_error: true feet from each support reached; the latter in rad.
        gap: least true one between the feet's outlines.
        tilt: largest true one of the torso [rad].
    """

    robot: str
    seed: int
    asked: int
    reached: int = 0
    fell: bool = False
    reason: str = ""
    steps: list[int] = field(default_factory=list)
    duration: list[float] = field(default_factory=list)
    one_foot: list[float] = field(default_factory=list)
    hottest: float = 0.0
    feet_error: list[tuple[float, float]] = field(default_factory=list)
    yaw_error: list[float] = field(default_factory=list)
    gap: float = float("inf")
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
        del motion, since
        walked, snap = self._walked, self._sim.snapshot()
        walked.hottest = max(walked.hottest, float(self._sim.joints(snap).temperatures.max()))
        left, right = (
            shapely.Polygon(position[:2] + foot.outline @ rotation[:2, :2].T)
            for position, rotation, foot in zip(
                snap.sole_position, snap.sole_rotation, self._sim.robot.feet, strict=True
            )
        )
        walked.gap = min(walked.gap, 1e3 * float(left.distance(right)))
        x, y = snap.base_orientation[:2]
        upward = 1.0 - 2.0 * (x * x + y * y)
        walked.tilt = max(walked.tilt, float(np.arccos(np.clip(upward, -1.0, 1.0))))

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
    settings = PlannerSettings()
    drawn = Feasible(robot, settings).draw(np.random.default_rng([seed, 2]))
    start, *goals = itertools.islice(drawn, supports + 1)
    planner = Planner(robot, settings)
    stepper, sim = Stepper(planner), simulated(seed)
    sim.place(planner.stance(start))
    walked = Walked(name, seed, len(goals))
    witness = Witness(sim, walked)
    try:
        for goal in goals:
            begin = time.perf_counter()
            motions = walk(sim, stepper, goal, witness)
            witness.arrived(goal)
            walked.reached += 1
            walked.steps.append(len(motions))
            walked.duration += [motion.duration for motion in motions]
            walked.one_foot += [_one_foot(motion) for motion in motions]
            _tell(walked, goal, time.perf_counter() - begin)
    except RobotFellError as error:
        walked.fell, walked.reason = True, str(error)
    except ShoecalError as error:
        walked.reason = str(error)
    if walked.reason:
        print(f"{name} {seed}: {walked.reason}", flush=True)
    return walked


def _one_foot(motion: Motion) -> float:
    return sum(
        phase.end - phase.begin
        for phase in motion.phases
        if phase.support_phase is not SupportPhase.BOTH
    )


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
    steps, duration, one_foot, gap, hottest, tilt = (
        _all(np.atleast_1d(getattr(walked, name)) for walked in walks)
        for name in ("steps", "duration", "one_foot", "gap", "hottest", "tilt")
    )
    off = _all(walked.feet_error for walked in walks)
    away, yaw = np.hypot(*off.T), np.abs(_all(walked.yaw_error for walked in walks))
    duration_s, one_foot_s, away_mm = (
        f"{np.median(of):.1f} ({of.max():.1f})" for of in (duration, one_foot, away)
    )
    asked, reached = (
        sum(getattr(walked, name) for walked in walks) for name in ("asked", "reached")
    )
    return {
        "robots drawn": f"{len(walks)}",
        "double supports asked for, reached": f"{asked}, {reached}",
        "falls": f"{sum(walked.fell for walked in walks)}",
        "steps taken; most for one support": f"{steps.sum():.0f}; {steps.max():.0f}",
        "duration of a step, median (worst) [s]": duration_s,
        "of it on one foot [s]": one_foot_s,
        "hottest motor [degC]": f"{hottest.max():.1f}",
        "true feet from where they should be [mm]": away_mm,
        "of it narrower, median [mm]": f"{np.median(off[:, 1]):.1f}",
        "the same in yaw [rad]": f"{np.median(yaw):.3f} ({yaw.max():.3f})",
        "least true gap between the feet [mm]": f"{gap.min():.1f}",
        "largest tilt of the torso [rad]": f"{tilt.max():.2f}",
    }


def _all(parts: Iterable[ArrayLike]) -> FloatArray:
    arrays = [np.asarray(part, dtype=np.float64) for part in parts]
    return np.concatenate([array for array in arrays if array.size])


def main() -> int:
    """Measure and write; fails when a robot fell or did not arrive."""
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
    return 0 if all(walked.reached == walked.asked for walked in walks) else 1


if __name__ == "__main__":
    raise SystemExit(main())
