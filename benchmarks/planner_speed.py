"""The fast solver beside others on the same problems, and each of its modes in closed loop.

    make planner-speed   (ARGS="--supports 1 --problems 8")

A robot's motions are planned in double supports with the converged mode, and every optimisation is
recorded. Then all solvers solve the same problems from the same guesses, in turns: problem by
problem, not solver by solver, so that whatever else the machine does meets all of them. Writes the
planner's sections of docs/evidence/performance.md and its key of out/bench.json.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import bench_json
import pages
from planner_cases import Case, Loop, closed_loop, evenly
from planner_crocoddyl import Crocoddyl, UnavailableError, python_with_crocoddyl
from planner_figures import (
    AIMS,
    COMPILED,
    CROCODDYL,
    MX,
    REFERENCES,
    SX,
    TARGETS,
    Measured,
    figures,
    missed,
    require_same_optimum,
)
from planner_growth import measure_growth, write_growth
from planner_race import InProcess, Racer, best_known, race
from planner_references import compiled_ipopt, judge, mx_ipopt
from planner_speed_page import speed_body
from shoecal_core.planning.horizon.ipopt import IpoptSolver
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import MODES, PlannerSettings

COMMAND = "make planner-speed"


def told(index: int, count: int) -> None:
    if index % 10 == 0 or index == count:
        print(f"race: {index} of {count} problems", flush=True)


def measure(case: Case, supports: int, problems: int, seed: int) -> Measured:
    """Plan, record, race."""
    settings = PlannerSettings()
    planner = Planner(case.robot, settings)
    collocation = planner.horizon.collocation
    modes = {mode: case.fast_solver(settings, mode) for mode in MODES}
    rescue = IpoptSolver(collocation)
    places = case.supports(supports, settings, seed)
    loops: dict[str, list[Loop]] = {name: [] for name in modes}
    for index, support in enumerate(places, start=1):
        for name, solver in modes.items():
            loops[name].append(closed_loop(planner, support, solver, [rescue]))
            print(f"closed loop, {name}: {index} of {len(places)}", flush=True)
    recorded = [solve for loop in loops["converged"] for solve in loop.solves]
    chosen = evenly(recorded, problems)
    racers: dict[str, Racer] = {name: InProcess(solver) for name, solver in modes.items()}
    racers |= {
        SX: InProcess(rescue),
        COMPILED: InProcess(compiled_ipopt(collocation)),
        MX: InProcess(mx_ipopt(collocation)),
    }
    missing = ""
    with ExitStack() as stack:
        try:
            python = python_with_crocoddyl()
            racers[CROCODDYL] = stack.enter_context(Crocoddyl(collocation, python))
        except UnavailableError as error:
            missing = str(error)
        results = race(racers, chosen, lambda index: told(index, len(chosen)))
    exact = {name: results[name] for name in ("converged", *REFERENCES)}
    best = best_known(judge(collocation), exact)
    return Measured(results, best, len(recorded), loops, missing)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write, and fail where a target is missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--supports", type=int, default=5)
    parser.add_argument("--problems", type=int, default=200, help="at most, evenly spaced")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--growth-problems", type=int, default=12, help="for each horizon")
    parser.add_argument("--page", type=Path, default=pages.PERFORMANCE, help="page to write into")
    parser.add_argument("--figures", type=Path, default=bench_json.PATH, help="figures as JSON")
    args = parser.parse_args(arguments)
    case = Case.named("nao")
    measured = measure(case, args.supports, args.problems, args.seed)
    found = figures(measured)
    bench_json.record("planner", found, args.figures)
    pages.write_performance("planner", speed_body(COMMAND, measured), args.page)
    write_growth(COMMAND, measure_growth(case, args.growth_problems, args.seed), args.page)
    broken = missed(found, TARGETS) + require_same_optimum(measured.results)
    for line in missed(found, AIMS):
        print(f"aim not met: {line}")
    for line in broken:
        print(f"missed: {line}")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
