"""Plan every motion of the menu, and tell its parts and how long they take.

    .venv/bin/python benchmarks/motion_menu.py

Each begins in the neutral double support. Writes a table of docs/reference/motions.md.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

from own_steps import ROBOTS, robot_of
from pages import ROOT, Row, markdown, write_section
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


def menu(motions: Mapping[str, Mapping[str, Motion]]) -> list[Row]:
    """A row a motion; its parts are those of the first robot."""
    first = next(iter(motions.values()))
    return [
        {
            "name": f"`{name}`",
            "what": kind.doc,
            "parts": parts(first[name].phases),
            **{f"{robot} [s]": f"{one[name].duration:.0f}" for robot, one in motions.items()},
        }
        for name, kind in MOTION_KINDS.items()
    ]


def main() -> None:
    """Plan and write."""
    rows = menu({name: planned(name) for name in ROBOTS})
    write_section("motion-menu", markdown(rows), PAGE)


if __name__ == "__main__":
    main()
