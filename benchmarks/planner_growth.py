"""How the time of an optimisation grows with the number of states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import pages
from planner_cases import Case, closed_loop, evenly, with_horizon
from planner_race import InProcess, Times, race
from shoecal_core.planning.horizon.ipopt import IpoptSolver
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.report.palette import BLUE, RED, Look
from shoecal_core.report.sheet import Part, write_sheet
from shoecal_core.report.svg import WIDTH, canvas, draw_line, line_key

HORIZONS = (5, 10, 20, 40)
FIGURE = "planner-growth.svg"
FAST, SLOW = "fast, converged", "IPOPT (SX)"
LOOKS: Mapping[str, Look] = {FAST: Look(RED, 1.8), SLOW: Look(BLUE, 1.8, (4.0, 1.5))}
HEIGHT = 190.0

BODY = """\
## The planner: how the time grows with the horizon

Made by `{command}`.

One double support planned in closed loop with N states per horizon; at most {problems} of its
optimisations, solved by both. Processor time, median (95th percentile) in ms, and median ratio.

{table}

![Processor time of one optimisation against the number of states](../figures/{figure})
"""


@dataclass(frozen=True)
class Growth:
    """Of one horizon: N, and the times of each solver on the same problems."""

    horizon: int
    times: Mapping[str, Times]


def measure_growth(case: Case, problems: int, seed: int) -> list[Growth]:
    """The same support with each horizon."""
    (support,) = case.supports(1, PlannerSettings(), seed)
    found = []
    for horizon in HORIZONS:
        settings = with_horizon(PlannerSettings(), horizon)
        planner = Planner(case.robot, settings)
        fast = case.fast_solver(settings, "converged")
        slow = IpoptSolver(planner.horizon.collocation)
        loop = closed_loop(planner, support, fast, [slow])
        racers = {FAST: InProcess(fast), SLOW: InProcess(slow)}
        solves = race(racers, evenly(loop.solves, problems))
        found.append(Growth(horizon, {name: Times.of(each) for name, each in solves.items()}))
        print(f"horizon {horizon}: measured", flush=True)
    return found


def write_growth(command: str, found: Sequence[Growth], page: Path = pages.PERFORMANCE) -> None:
    """Its section of docs/evidence/performance.md, and its figure in docs/figures."""
    figure = page.parent.parent / "figures" / FIGURE
    rows = [["N", *LOOKS, "ratio"]]
    for growth in found:
        cells = [growth.times[name].summary for name in LOOKS]
        ratio = growth.times[SLOW].ratios(growth.times[FAST])[0]
        rows.append(
            [
                str(growth.horizon),
                *(f"{1e3 * median:.1f} ({1e3 * most:.1f})" for median, most, *_ in cells),
                f"{ratio:.1f}",
            ]
        )
    problems = max(len(growth.times[FAST].values) for growth in found)
    alt = "Median processor time of one optimisation in ms: " + "; ".join(
        f"N = {row[0]}: fast {row[1]}, IPOPT {row[2]}" for row in rows[1:]
    )
    figure.parent.mkdir(exist_ok=True)
    write_sheet(figure, [[Part("Processor time of one optimisation", drawn(found, alt))]], alt)
    body = BODY.format(
        command=command, problems=problems, table=pages.table(rows), figure=figure.name
    )
    pages.write_performance("planner-growth", body, page)


def drawn(found: Sequence[Growth], alt: str) -> str:
    """Both on logarithmic axes: what grows like a power of N is a straight line."""
    horizons = np.array([growth.horizon for growth in found], dtype=np.float64)
    with canvas(HEIGHT) as page:
        page.legend([line_key(look, name) for name, look in LOOKS.items()], left=46.0)
        axes = page.panel(26.0, HEIGHT - 66.0, left=52.0, right=WIDTH - 10.0)
        for name, look in LOOKS.items():
            medians = np.array([1e3 * growth.times[name].summary[0] for growth in found])
            draw_line(axes, horizons, medians, look)
            axes.plot(horizons, medians, "o", color=look.colour.light, markersize=4.0)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_xticks(horizons, [f"{horizon:.0f}" for horizon in horizons])
        axes.set_xticks([], minor=True)
        ticks = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
        low, high = axes.get_ylim()
        shown = [tick for tick in ticks if low <= tick <= high]
        axes.set_yticks(shown, [str(tick) for tick in shown])
        axes.set_yticks([], minor=True)
        axes.set_xlabel("states of a horizon, N")
        axes.set_ylabel("median (ms)")
        return page.svg(alt)
