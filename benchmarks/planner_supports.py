"""Motions in many random double supports, and all motions of the menu in a few.

    make planner-supports   (ARGS="--nao 20 --wren 5", ARGS="--only-physics --physics 7")

Draws double supports of each robot's range, plans a motion in each that the robot can be asked to
stand in, and checks it independently. A run that was stopped goes on where it was. Writes the
planner's section on double supports in docs/evidence/performance.md. Then lets simulated robots
follow some motions, and writes loads, friction and torques, planned and in the physics, into
docs/evidence/own-steps.md. Fails where a motion failed, violates a constraint, or a figure is
beyond its limit.
"""

from __future__ import annotations

import argparse
import itertools
import multiprocessing
import sys
from collections.abc import Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path

import pages
from planner_balance import Kept, Simulated, balance_body, beyond, simulated
from planner_cases import OUT
from planner_outcomes import FAILED, PLANNED, REFUSED, Job, Memory, Outcome, attempt
from planner_supports_page import supports_body
from shoecal_core.planning.motion_catalogue import MOTION_KINDS

COMMAND = "make planner-supports"
MOTIONS_PAGE = pages.ROOT / "docs" / "evidence" / "own-steps.md"
ROBOTS = ("nao", "wren", "odd_biped")


class Survey:
    """Outcomes of jobs, those that are known and those that a pool still has to find."""

    def __init__(self, pool: Executor, memory: Memory) -> None:
        self._pool, self._memory = pool, memory
        self._known = memory.known()

    def of(self, jobs: Sequence[Job], told: str) -> list[Outcome]:
        """The outcomes of jobs, in their order."""
        missing = [job for job in jobs if job not in self._known]
        for done, outcome in enumerate(self._pool.map(attempt, missing), start=1):
            self._memory.add(outcome)
            self._known[outcome.job] = outcome
            print(f"{told}: {done} of {len(missing)}, {outcome.end}", flush=True)
        return [self._known[job] for job in jobs]

    def usable(self, robot: str, count: int, seed: int) -> list[Outcome]:
        """Outcomes until `count` are of double supports that were not refused; refused ones too."""
        found: list[Outcome] = []
        while (wanted := count - sum(outcome.end != REFUSED for outcome in found)) > 0:
            jobs = [Job(robot, seed, len(found) + i) for i in range(wanted)]
            found += self.of(jobs, robot)
        return found


def followed(pool: Executor, kept: Kept, count: int, seed: int) -> list[Simulated]:
    """`count` motions of each robot that were followed, those that are known first; refused too."""
    known, found = kept.known(), list[Simulated]()
    for robot in ROBOTS:
        mine: list[Simulated] = []
        while (wanted := count - sum(not one.refused for one in mine)) > 0:
            names = itertools.islice(itertools.cycle(MOTION_KINDS), len(mine), len(mine) + wanted)
            jobs = [Job(robot, seed, len(mine) + i, name) for i, name in enumerate(names)]
            missing = [job for job in jobs if job not in known]
            for one in pool.map(simulated, missing):
                kept.add(one)
                known[one.job] = one
                print(f"{one.job}: {one.refused or one.physics}", flush=True)
            mine += [known[job] for job in jobs]
        found += mine
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Plan, write, and fail where a motion failed or violates a constraint."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--nao", type=int, default=200)
    parser.add_argument("--wren", type=int, default=50)
    parser.add_argument("--menu", type=int, default=3, help="double supports for all motions")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=OUT, help="folder that remembers outcomes")
    parser.add_argument("--page", type=Path, default=pages.PERFORMANCE, help="page to write into")
    parser.add_argument("--physics", type=int, default=34, help="simulated motions a robot")
    parser.add_argument("--only-physics", action="store_true", help="leave the rest out")
    parser.add_argument("--motions-page", type=Path, default=MOTIONS_PAGE)
    args = parser.parse_args(arguments)
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(args.workers, mp_context=spawn) as pool:
        results = followed(pool, Kept(args.out), args.physics, args.seed)
        body = balance_body(COMMAND, results)
        pages.write_section("planner-balance", body, args.motions_page, "# Motions\n")
        if wrong_figures := beyond(results):
            print("\n".join(wrong_figures))
        if args.only_physics:
            return 1 if wrong_figures else 0
        survey = Survey(pool, Memory(args.out))
        drawn, menu = [], []
        for robot in ("nao", "wren"):
            found = survey.usable(robot, getattr(args, robot), args.seed)
            drawn += found
            few = [outcome.job.index for outcome in found if outcome.end == PLANNED][: args.menu]
            jobs = [
                Job(robot, args.seed, index, motion) for motion in MOTION_KINDS for index in few
            ]
            menu += survey.of(jobs, f"{robot}, menu")
    pages.write_performance("planner-supports", supports_body(COMMAND, drawn, menu), args.page)
    wrong = [o for o in (*drawn, *menu) if o.end == FAILED or o.violated]
    for outcome in wrong:
        print(f"{outcome.job}: {outcome.cause[1] or ', '.join(outcome.violated)}")
    return 1 if wrong or wrong_figures else 0


if __name__ == "__main__":
    sys.exit(main())
