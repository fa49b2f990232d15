"""What the race of the planner's solvers comes to, in numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from planner_cases import Loop
from planner_race import Results, Times, disagreements, share_converged

FloatArray = NDArray[np.float64]
MX, COMPILED, SX = "ipopt_mx", "ipopt_compiled", "ipopt_sx"
REFERENCES = (MX, COMPILED, SX)
CROCODDYL = "crocoddyl"


@dataclass(frozen=True)
class Measured:
    """Everything that was measured.

    Attributes:
        results: of every solver, problem by problem.
        best: (P,) lowest objectives known.
        recorded: problems there were, of which all or evenly spaced ones were solved.
        loops: of every mode in closed loop, support by support.
        missing: why crocoddyl is not among them; empty where it is.
    """

    results: Results
    best: FloatArray
    recorded: int
    loops: Mapping[str, Sequence[Loop]]
    missing: str


def figures(measured: Measured) -> dict[str, dict[str, float]]:
    """The key `planner` of out/bench.json.

    `p99_ms` is by the clock: what counts is that the robot need not wait. `p99_cpu_ms` is the
    processor's time.
    """
    found: dict[str, dict[str, float]] = {}
    for mode, loops in measured.loops.items():
        fast = Times.of(measured.results[mode])
        found[mode] = {
            f"vs_{name}": Times.of(measured.results[name]).ratios(fast)[0]
            for name in (MX, COMPILED)
        }
        if mode == "converged":
            found[mode]["share_converged"] = share_converged(measured.results[mode], measured.best)
        elif mode == "bounded":
            found[mode]["p99_ms"] = 1e3 * Times.of(measured.results[mode], "wall").summary[2]
            found[mode]["p99_cpu_ms"] = 1e3 * fast.summary[2]
            found[mode]["max_violation"] = max(loop.violation for loop in loops)
        elif mode == "realtime":
            found[mode]["foot_error"] = max(loop.foot_error for loop in loops)
    return found


def require_same_optimum(results: Results) -> list[str]:
    """Lines on references that disagree; they are ways to compute the same."""
    return [
        f"{name} finds another optimum of problem {index}: {difference:.1e} of it"
        for index, name, difference in disagreements(results, REFERENCES)
    ]


TARGETS: Mapping[tuple[str, str], float] = {
    ("converged", "vs_ipopt_mx"): 10.0,
    ("converged", "vs_ipopt_compiled"): 4.0,
    ("converged", "share_converged"): 0.99,
    ("bounded", "vs_ipopt_mx"): 20.0,
    ("bounded", "vs_ipopt_compiled"): 8.0,
    ("bounded", "p99_ms"): 10.0,
    ("bounded", "max_violation"): 1e-5,
    ("realtime", "foot_error"): 1e-9,
}
AIMS: Mapping[tuple[str, str], float] = {
    ("converged", "vs_ipopt_mx"): 25.0,
    ("realtime", "vs_ipopt_mx"): 60.0,
    ("realtime", "vs_ipopt_compiled"): 25.0,
}
AT_MOST = ("p99_ms", "max_violation", "foot_error")
"""Of these less is better, of all others more."""


def missed(
    found: Mapping[str, Mapping[str, float]], wanted: Mapping[tuple[str, str], float]
) -> list[str]:
    """Those of TARGETS or AIMS that were not met."""
    lines = []
    for (mode, key), bound in wanted.items():
        value = found[mode][key]
        less = key in AT_MOST
        if not (value <= bound if less else value >= bound):
            lines.append(
                f"{mode} {key}: {value:.3g}, not at {'most' if less else 'least'} {bound:g}"
            )
    return lines
