from __future__ import annotations

from pathlib import Path

import numpy as np

import shoecal_core.planning
from planner_outcomes import FAILED, PLANNED, Job, Memory, Outcome, sources
from planner_supports_page import supports_body
from shoecal_core.planning.settings import PlannerSettings

REACHED = PlannerSettings().landmark_radius / 2.0
DONE = Outcome(
    Job("nao", 1, 0), (0.0, -0.1, 0.2), PLANNED, wall=2.0, cpu=1.0, solves=30,
    duration=25.0, nearest=(REACHED, 0.0123, np.inf),
)  # fmt: skip
UNDONE = Outcome(Job("nao", 1, 1), (0.0, -0.1, 0.1), FAILED, cause=("PlanningError", "no way"))


def test_outcomes_are_remembered_also_when_the_last_line_was_cut(tmp_path: Path) -> None:
    memory = Memory(tmp_path)
    memory.add(DONE)
    memory.add(UNDONE)
    assert Memory(tmp_path).known() == {DONE.job: DONE, UNDONE.job: UNDONE}
    memory.file.write_text(memory.file.read_text()[:-5])
    again = Memory(tmp_path)
    assert again.known() == {DONE.job: DONE}
    again.add(UNDONE)
    assert again.known() == {DONE.job: DONE, UNDONE.job: UNDONE}


def test_outcomes_are_those_of_every_module_of_planning() -> None:
    """Also of those in packages within it: a changed one begins a new file."""
    folder = Path(shoecal_core.planning.__file__).parent
    assert set(folder.rglob("*.py")) <= set(sources())


def test_the_page_tells_failures_and_landmarks_out_of_reach() -> None:
    body = supports_body("make it", [DONE, UNDONE], [DONE])
    assert "| nao | landmarks | PlanningError | 1 | no way |" in body
    assert "| nao | 0.000 | -0.100 | 0.200 | 1 | 12.3 | impossible |" in body
    assert "| nao | 2 | 0 | 1 | 1 | 0 | 2 of 4 | 2.00 (2.00) |" in body
