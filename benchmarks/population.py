"""Simulated sessions that several benchmarks measure on: made once, kept, and taken up again.

    .venv/bin/python benchmarks/population.py [--seeds 200] [--out out/population]

Every seed draws another robot, other cells and other double supports of the default reality.
A session that stands already is not made again, so an interrupted run goes on.
"""

from __future__ import annotations

import argparse
import os
import shutil
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from shoecal_core.planning.motion_sets import PlannedRun, listed_runs
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.simulation.reality_file import load_reality
from shoecal_core.workflows.simulated_session import SimulationPlan, simulate_session
from shoecal_core.workspace import config_dir

ROOT = Path(__file__).resolve().parents[1]
OUT = ROOT / "out" / "population"
SUPPORTS = 5
TRAIN = 3
RATE_HZ = 100.0


@dataclass(frozen=True)
class Member:
    """One session of a population.

    Attributes:
        seed: of supports and noise.
        robot_seed: of robot and cells.
        folder: where the session stands.
    """

    seed: int
    robot_seed: int
    folder: Path

    @property
    def train(self) -> tuple[int, ...]:
        """Runs drawn for training, as the paper draws three of five."""
        runs = np.random.default_rng([self.seed, 3]).permutation(SUPPORTS)[:TRAIN] + 1
        return tuple(sorted(runs.tolist()))

    @property
    def test(self) -> tuple[int, ...]:
        """The others."""
        return tuple(run for run in range(1, SUPPORTS + 1) if run not in self.train)


def different_robots(count: int, out: Path = OUT) -> list[Member]:
    """Seeds 1 to `count`, each another robot."""
    return [Member(seed, seed, out / f"seed_{seed:03d}") for seed in range(1, count + 1)]


def one_robot(robot_seed: int, count: int, out: Path = OUT) -> list[Member]:
    """The same robot calibrated `count` times, in other double supports each time."""
    return [
        Member(1000 * robot_seed + again, robot_seed, out / f"robot_{robot_seed:03d}_{again:02d}")
        for again in range(1, count + 1)
    ]


def sessions(members: Sequence[Member]) -> Iterator[tuple[Member, Session]]:
    """Every member's session in order, made where it does not stand yet."""
    missing = [member for member in members if not member.folder.is_dir()]
    if missing:
        with ProcessPoolExecutor(os.cpu_count()) as pool:
            for done, member in enumerate(pool.map(_make, missing), start=1):
                print(f"{member.folder.name}: {done} of {len(missing)}", flush=True)
    for member in members:
        yield member, Session.open(member.folder)


@cache
def nao() -> tuple[Robot, Shoe]:
    """The robot and the shoes of every member."""
    shoe = load_shoe(config_dir() / "shoes" / "nao_shoe.yaml")
    return load_robot(config_dir() / "robots" / "nao.yaml", shoe), shoe


def paper_runs(supports: Sequence[DoubleSupport]) -> tuple[PlannedRun, ...]:
    """The paper's own protocol: one motion over landmarks in each double support."""
    return listed_runs(supports, ["landmarks"] * len(supports))


def make_session(
    folder: Path,
    runs: Sequence[PlannedRun],
    *,
    seed: int,
    robot_seed: int,
    reality: Path | None = None,
) -> None:
    """Simulate a session of the NAO; whole or not at all: an interrupted one counts as not made.

    Args:
        folder: to make.
        runs: in double supports that were drawn.
        seed: of the noise.
        robot_seed: of robot and cells.
        reality: changes to the default reality.
    """
    robot, shoe = nao()
    plan = SimulationPlan(
        robot=robot,
        shoe=shoe,
        reality=load_reality(config_dir() / "realities" / "default.yaml", reality),
        settings=PlannerSettings(),
        runs=runs,
        rate=RATE_HZ,
        seed=seed,
        robot_seed=robot_seed,
        drawn=True,
    )
    begun = folder.with_name(folder.name + ".begun")
    shutil.rmtree(begun, ignore_errors=True)
    begun.parent.mkdir(parents=True, exist_ok=True)
    simulate_session(plan, begun, lambda *_: None)
    begun.rename(folder)


def _make(member: Member) -> Member:
    robot, shoe = nao()
    supports = draw_supports(robot, shoe, PlannerSettings(), SUPPORTS, member.seed)
    make_session(
        member.folder, paper_runs(supports), seed=member.seed, robot_seed=member.robot_seed
    )
    return member


def main() -> None:
    """Make a population."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--out", type=Path, default=OUT)
    args = parser.parse_args()
    for _ in sessions(different_robots(args.seeds, args.out)):
        pass


if __name__ == "__main__":
    main()
