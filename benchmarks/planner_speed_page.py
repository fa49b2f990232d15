"""The planner's sections of docs/evidence/performance.md."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

import pages
from planner_cases import Loop
from planner_crocoddyl import PINNED, SOLVER
from planner_figures import (
    AIMS,
    COMPILED,
    CROCODDYL,
    MX,
    SX,
    TARGETS,
    Measured,
    figures,
    missed,
)
from planner_race import CONVERGED, FEASIBLE, Times, share_converged
from shoecal_core.compiled import compiler_state
from shoecal_core.planning.settings import PlannerSettings

NAMES: Mapping[str, str] = {
    "converged": "fast, converged",
    "bounded": "fast, bounded",
    "realtime": "fast, real-time iteration",
    SX: "IPOPT, scalar expressions (SX), interpreted",
    COMPILED: "IPOPT, all functions as machine code",
    MX: "IPOPT, matrix expressions (MX), interpreted",
    CROCODDYL: "crocoddyl, penalties for constraints",
}

BODY = """\
## The planner: solvers side by side

Made by `{command}`.

The motions of a simulated NAO in {supports} double supports, N = {horizon} states, planned in
closed loop by the fast solver until it converges: {recorded} optimisations, {sampled}. All
solvers get the same problems and guesses, alternating, after solving the previous problem once
more (as warm as in closed loop). Times are processor time of all threads, and clock time.
*Converged*: all constraints within {feasible:g} and the objective within a share of {converged:g}
of the best known, judged by IPOPT with a tolerance of 1e-10 and unrelaxed bounds.

{times}

Speed-up over the references: median ratio over problems, then ratios of the 95th and 99th
percentiles and of the totals.

{ratios}

Targets: median ratio of processor time; 99th percentile of the bounded mode at most {bound:g} ms
by the clock: {clock:.2f} ms (processor {cpu:.2f} ms).

{missed}

IPOPT uses MUMPS and the planner's tolerances and warm start; its three variants find the same
optimum (to {spread:.0e}). Machine code: all functions of the MX problem with first and second
derivatives, -O3.

{crocoddyl}

Motions planned with each mode alone (IPOPT as fallback). Largest violation: of any constraint by an
applied state, in m, rad or N m, also in the first table for the bounded and real-time mode. Last
column: independent check of the motion on a denser grid, by Pinocchio.

{loops}

Measured on {cores} cores ({machine}), OPENBLAS_NUM_THREADS {threads}, with Python {python}, numpy
{numpy}, CasADi {casadi}; {compiled}.
"""

CROCODDYL_TEXT = """\
crocoddyl ({version}) solves the same problem except for the constraints: foot transform, polygon,
capsules, torques and joint limits are quadratic penalties, as in its examples, because {solver}
supports only a box on u (solvers with equalities were not measured). It ends with violations of
{median:.0e} (median) to {worst:.0e} (m, rad or N m) and an objective {below:.2%} below the true
optimum (median); {stopped:.0%} of its solves do not converge. Its models are Python over the fast
solver's compiled
function; its iterations are C++."""

CERTIFIED = ("converged", SX, COMPILED, MX)
"""Those that claim an optimum which keeps all constraints."""


def speed_body(command: str, measured: Measured) -> str:
    """The section on solvers."""
    sampled = len(next(iter(measured.results.values())))
    loops, found = measured.loops["converged"], figures(measured)
    return BODY.format(
        command=command,
        supports=len(loops),
        horizon=len(loops[0].solves[0].guess),
        recorded=measured.recorded,
        sampled="all of them raced"
        if sampled == measured.recorded
        else f"of which {sampled}, evenly spaced, raced",
        feasible=FEASIBLE,
        converged=CONVERGED,
        times=_times(measured),
        ratios=_ratios(measured),
        bound=TARGETS["bounded", "p99_ms"],
        clock=found["bounded"]["p99_ms"],
        cpu=found["bounded"]["p99_cpu_ms"],
        missed=_missed(found),
        spread=_spread(measured),
        crocoddyl=_crocoddyl(measured),
        loops=_loops(measured.loops),
        cores=os.cpu_count(),
        machine=platform.machine(),
        threads=os.environ.get("OPENBLAS_NUM_THREADS", "not set"),
        python=platform.python_version(),
        numpy=np.__version__,
        casadi=ca.CasadiMeta.version(),
        compiled=compiler_state().get("compiler", "no C compiler"),
    )


def _times(measured: Measured) -> str:
    head = [
        "solver", "median [ms]", "95 % [ms]", "99 % [ms]", "total [s]", "median by the clock [ms]",
        "99 % by the clock [ms]", "iterations, median", "converged", "largest violation",
    ]  # fmt: skip
    rows = [head]
    for name in NAMES:
        if name not in measured.results:
            continue
        solves = measured.results[name]
        median, most, nearly_all, total = Times.of(solves).summary
        wall = Times.of(solves, "wall").summary
        violations = [solve.solution.violation for solve in solves]
        share = "-"
        if name in CERTIFIED:
            share = f"{100.0 * share_converged(solves, measured.best):.1f} %"
        rows.append(
            [
                NAMES[name],
                *(f"{1e3 * value:.2f}" for value in (median, most, nearly_all)),
                f"{total:.2f}",
                f"{1e3 * wall[0]:.2f}",
                f"{1e3 * wall[2]:.2f}",
                f"{np.median([solve.solution.iterations for solve in solves]):.0f}",
                share,
                f"{max(violations):.1e}",
            ]
        )
    return pages.table(rows)


def _ratios(measured: Measured) -> str:
    rows = [["mode", "against", "median", "at 95 %", "at 99 %", "total", "median by the clock"]]
    for mode in measured.loops:
        for name in (MX, COMPILED, SX):
            fast, slow = measured.results[mode], measured.results[name]
            ratios = Times.of(slow).ratios(Times.of(fast))
            clock = Times.of(slow, "wall").ratios(Times.of(fast, "wall"))[0]
            rows.append([NAMES[mode], NAMES[name], *(f"{r:.1f}" for r in (*ratios, clock))])
    return pages.table(rows)


def _missed(found: Mapping[str, Mapping[str, float]]) -> str:
    """Targets, which have to be met, and aims beyond them: those that were not."""
    told = []
    for what, wanted in (("target", TARGETS), ("aim", AIMS)):
        lines = missed(found, wanted)
        met = f"{len(wanted) - len(lines)} of {len(wanted)} {what}s met"
        listed = f"; missed: {'; '.join(f'`{line}`' for line in lines)}" if lines else ""
        told.append(f"{met}{listed}.")
    return "\n".join(told)


def _spread(measured: Measured) -> float:
    """Largest difference of the references' objectives."""
    costs = np.array(
        [[solve.solution.cost for solve in measured.results[name]] for name in (SX, MX, COMPILED)]
    )
    low, high = costs.min(axis=0), costs.max(axis=0)
    return float(np.max((high - low) / np.maximum(1.0, low)))


def _crocoddyl(measured: Measured) -> str:
    if measured.missing:
        return f"crocoddyl could not be installed here: {measured.missing}."
    solves = measured.results[CROCODDYL]
    violations = np.array([solve.solution.violation for solve in solves])
    costs = np.array([solve.solution.cost for solve in solves])
    stopped = np.array([solve.solution.status == "Stopped" for solve in solves])
    return CROCODDYL_TEXT.format(
        version=PINNED[0].partition("==")[2],
        solver=SOLVER,
        median=np.median(violations),
        worst=violations.max(),
        below=float(np.median(1.0 - costs / measured.best)),
        stopped=float(stopped.mean()),
    )


def _loops(loops: Mapping[str, Sequence[Loop]]) -> str:
    rows = [
        ["mode", "optimisations", "of them by IPOPT", "processor time a support [s]",
         "landmarks reached", "motion [s]", "foot transform off by", "largest violation", "check"]
    ]  # fmt: skip
    radius = PlannerSettings().landmark_radius
    for mode, found in loops.items():
        solves = sum(len(loop.solves) for loop in found)
        rescued = sum(len(loop.rescues) for loop in found)
        nearest = np.concatenate([loop.planned.nearest[1:] for loop in found])
        failed = [finding for loop in found for finding in loop.findings if not finding.kept]
        rows.append(
            [
                NAMES[mode],
                str(solves),
                str(rescued),
                f"{np.median([loop.span.cpu for loop in found]):.2f}",
                f"{np.sum(nearest < radius)} of {len(nearest)}",
                f"{np.median([loop.motion.duration for loop in found]):.1f}",
                f"{max(loop.foot_error for loop in found):.1e}",
                f"{max(loop.violation for loop in found):.1e}",
                "kept" if not failed else f"{len(failed)} violated: {failed[0].constraint}",
            ]
        )
    return pages.table(rows)
