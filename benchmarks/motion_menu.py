"""Plan every motion of the menu, and tell its parts and how long they take.

    .venv/bin/python benchmarks/motion_menu.py

Each begins in the neutral double support. Writes a section of docs/reference/motions.md.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from own_steps import ROBOTS, robot_of
from pages import ROOT, table, write_section
from shoecal_core.planning.motion import Motion, Phase
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.named import named_support

PAGE = ROOT / "docs" / "reference" / "motions.md"


def planned(name: str) -> dict[str, Motion]:
    """All motions of one robot."""
    robot, _ = robot_of(name)
    settings = PlannerSettings()
    planner = Planner(robot, settings)
    neutral = named_support("neutral", Feasible(robot, settings))
    return {motion: planner.plan(neutral, motion) for motion in MOTION_KINDS}


def parts(phases: Sequence[Phase]) -> str:
    """Their names, in order, each once where it repeats."""
    return ", ".join(
        f"{name} (on the {support_phase.value} foot)" if support_phase.value != "both" else name
        for (name, support_phase), _ in itertools.groupby(
            phases, lambda one: (one.name, one.support_phase)
        )
    )


def section(motions: dict[str, dict[str, Motion]]) -> str:
    """The part of the page."""
    first = next(iter(motions.values()))
    rows = [["name", "what", "parts", *(f"{name} [s]" for name in motions)]]
    for name, kind in MOTION_KINDS.items():
        lasting = [f"{one[name].duration:.0f}" for one in motions.values()]
        rows.append([f"`{name}`", kind.doc, parts(first[name].phases), *lasting])
    return f"""\
How long they take from the neutral double support (`make motion-menu`, benchmarks/motion_menu.py):

{table(rows)}
"""


def main() -> None:
    """Plan and write."""
    write_section(
        "motion-menu", section({name: planned(name) for name in ROBOTS}), PAGE, "# Motions\n"
    )


if __name__ == "__main__":
    main()
