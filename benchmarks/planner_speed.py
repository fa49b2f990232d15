"""The planner's solver beside IPOPT, and motions in many double supports.

    make planner-speed   (ARGS="--supports 1 --nao 20 --wren 5")

Writes two sections of docs/evidence/performance.md and the key `planner` of out/bench.json. Fails
where a motion failed or violates a constraint, or where the solver finds another optimum.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Mapping, Sequence

import numpy as np

import pages
from planner_problems import Posed, Timed, compiled_ipopt, judge, posed_in_closed_loop, race
from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError
from shoecal_core.planning.checking.check import check_motion
from shoecal_core.planning.horizon.collocation import Collocation
from shoecal_core.planning.horizon.ipopt import IpoptSolver
from shoecal_core.planning.horizon.problem import Solver
from shoecal_core.planning.horizon.sqp import SqpSolver
from shoecal_core.planning.legs import Legs
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.draw import draw_supports
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.workspace import config_dir

OURS = "shoecal"
PEER, INTERPRETED = "IPOPT, compiled", "IPOPT"
FEASIBLE = 1e-5
"""Largest violation with which an objective counts; a violation can buy a better one."""
CONVERGED = 1e-6
"""Largest difference from the best objective known, as a share of it."""

SOLVERS = """\
## The planner's solver against IPOPT

Made by `make planner-speed`.

Every optimisation of a simulated NAO's motions in {supports} double supports ({problems}), planned
in closed loop; all solvers get the same problems and guesses, in turns, as warm as in closed loop.
Processor time. IPOPT: MUMPS, the planner's own tolerances and warm start. *Compiled*: all functions
and derivatives as machine code (-O3), which needs a compiler for each robot; the planner's own
solver and the other IPOPT, its fallback, need none.
*Converged*: all constraints within {feasible:g} and the objective within {converged:g} of the best,
judged by IPOPT with a tolerance of 1e-10. *Ratio*: median over problems of the time of compiled
IPOPT over that of the solver.

{table}

{machine}
"""
MOTIONS = """\
## Motions in many double supports

Made by `make planner-speed`.

Random double supports without collision from each robot's range. *Refused*: the robot cannot stand
there, or above too few landmarks. In the others a motion over the landmarks is planned and checked
independently. Processor time of planning and checking.

{table}

{machine}
"""


def compare(
    collocation: Collocation, posed: Sequence[Posed]
) -> tuple[list[dict[str, object]], bool]:
    """Rows of the table, and whether the planner's solver found every optimum."""
    solvers: dict[str, Solver] = {
        OURS: SqpSolver(collocation),
        PEER: compiled_ipopt(collocation),
        INTERPRETED: IpoptSolver(collocation),
    }
    found = race(solvers, posed)
    best = _best(judge(collocation), posed, found)
    peer = np.array([one.seconds for one in found[PEER]])
    rows: list[dict[str, object]] = []
    for name, timed in found.items():
        seconds = np.array([one.seconds for one in timed])
        gaps = np.abs(np.array([_objective(one) for one in timed]) / best - 1.0)
        ratio = float(np.median(peer / seconds)) if name != PEER else None
        rows.append(
            {
                "solver": name,
                "median [ms]": 1e3 * float(np.median(seconds)),
                "99 % [ms]": 1e3 * float(np.percentile(seconds, 99)),
                "ratio": ratio,
                "converged [%]": 100.0 * float(np.mean(gaps <= CONVERGED)),
                "largest violation": max(one.solution.violation for one in timed),
            }
        )
    return rows, rows[0]["converged [%]"] == 100.0


def _best(
    judging: Solver, posed: Sequence[Posed], found: Mapping[str, Sequence[Timed]]
) -> FloatArray:
    """(P,) objectives that a judge finds from the best solution of each problem."""
    best = []
    for one, timed in zip(posed, zip(*found.values(), strict=True), strict=True):
        start = min(timed, key=_objective)
        judged = judging.solve(one.problem, start.solution.states)
        best.append(judged.cost if judged.converged else _objective(start))
    return np.array(best)


def _objective(timed: Timed) -> float:
    """Infinite where constraints are not kept."""
    solution = timed.solution
    return solution.cost if solution.violation <= FEASIBLE else np.inf


def survey(name: str, planner: Planner, count: int, seed: int) -> dict[str, object]:
    """A robot's row: what became of planning in `count` double supports that are not refused."""
    robot, settings = planner.legs.robot, planner.settings
    feasible = Feasible(robot, settings)
    apart = feasible.apart()
    planned = failed = violated = refused = reached = places = 0
    spent, lasting = [], []
    for index in np.random.default_rng(seed).permutation(len(apart)):
        if planned + failed == count:
            break
        support = apart[int(index)]
        if not feasible.can_stand(support):
            refused += 1
            continue
        begin = time.process_time()
        try:
            motion = planner.plan(support)
        except ShoecalError as error:
            failed += 1
            print(f"{name}, {support}: {error}")
            continue
        violated += bool(check_motion(planner.legs, motion, settings).violated)
        spent.append(time.process_time() - begin)
        lasting.append(motion.duration)
        planned += 1
        nearest = np.array(motion.path.nearest)
        reached += int(np.sum(nearest < settings.landmark_radius))
        places += len(nearest)
        print(f"{name}: {planned} of {count}", flush=True)
    return {
        "robot": name,
        "refused": refused,
        "planned": planned,
        "failed": failed,
        "violate a constraint": violated,
        "landmarks reached": f"{reached} of {places}",
        "median [s]": float(np.median(spent)),
        "95 % [s]": float(np.percentile(spent, 95)),
        "motion [s]": float(np.median(lasting)),
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write, and fail where a motion or an optimum was missed."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--supports", type=int, default=5, help="whose optimisations are raced")
    parser.add_argument("--nao", type=int, default=200, help="double supports to plan in")
    parser.add_argument("--wren", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args(arguments)
    settings, config = PlannerSettings(), config_dir()
    planners, motions = {}, []
    for name in ("nao", "wren"):
        shoe = load_shoe(config / "shoes" / f"{name}_shoe.yaml")
        robot = load_robot(config / "robots" / f"{name}.yaml", shoe)
        planners[name] = robot, shoe, Planner(robot, settings)
        motions.append(survey(name, planners[name][2], getattr(args, name), args.seed))
    robot, shoe, planner = planners["nao"]
    supports = draw_supports(robot, shoe, settings, args.supports, args.seed)
    collocation = Collocation(Legs(robot), settings)
    angles = [planner.stance(support) for support in supports]
    posed = posed_in_closed_loop(planner, SqpSolver(collocation), angles)
    solvers, optimal = compare(collocation, posed)
    pages.record("planner", {"solvers": solvers, "motions": motions})
    told = {
        "planner": SOLVERS.format(
            supports=len(supports), problems=f"{len(posed):,}", feasible=FEASIBLE,
            converged=CONVERGED, table=pages.markdown(solvers), machine=pages.machine(),
        ),
        "planner-supports": MOTIONS.format(
            table=pages.markdown(motions), machine=pages.machine()
        ),
    }  # fmt: skip
    for section, body in told.items():
        pages.write_section(section, body, pages.PERFORMANCE)
    wrong = [row for row in motions if row["failed"] or row["violate a constraint"]]
    if not optimal:
        print("missed: every optimum")
    return 1 if wrong or not optimal else 0


if __name__ == "__main__":
    sys.exit(main())
