"""Motions in many random double supports, and all motions of the menu in a few.

    make planner-supports   (ARGS="--nao 20 --wren 5")

Draws double supports of each robot's range, plans a motion in each that the robot can be asked to
stand in, and checks it independently. A run that was stopped goes on where it was. Writes the
planner's section on double supports in docs/evidence/performance.md; fails where a motion failed or
violates a constraint.
"""

from __future__ import annotations

import argparse
import multiprocessing
import sys
from collections.abc import Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from pathlib import Path

import pages
from planner_cases import OUT
from planner_outcomes import FAILED, PLANNED, REFUSED, Job, Memory, Outcome, attempt
from planner_supports_page import supports_body
from shoecal_core.planning.motion_catalogue import MOTION_KINDS

COMMAND = "make planner-supports"


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
    args = parser.parse_args(arguments)
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(args.workers, mp_context=spawn) as pool:
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
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
