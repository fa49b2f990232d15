"""Where a motion cannot be done in a double support that was drawn, another one is drawn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from core.simulation.worlds import DEFAULT, load_world
from shoecal_core.planning.motion_sets import PlannedRun
from shoecal_core.planning.posture import UnreachableError
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.workflows.simulated_session import SimulationPlan, simulate_session

AWKWARD = DoubleSupport(0.04, -0.144, -0.52)
"""In it NAO can stand above all landmarks, and not on its right foot alone."""
EASY = DoubleSupport(0.0, -0.1, 0.0)


def plan(*runs: PlannedRun, drawn: bool) -> SimulationPlan:
    nao = load_world("nao")
    return SimulationPlan(
        robot=nao.robot,
        shoe=nao.shoe,
        reality=DEFAULT,
        settings=PlannerSettings(),
        runs=runs,
        rate=20.0,
        seed=107,
        robot_seed=107,
        drawn=drawn,
    )


def simulated(wanted: SimulationPlan, folder: Path) -> tuple[Session, list[str]]:
    told: list[str] = []
    session = simulate_session(wanted, folder, lambda text, _share: told.append(text))
    return session, told


def test_another_double_support_is_drawn_and_told(tmp_path: Path) -> None:
    wanted = plan(PlannedRun(AWKWARD, "unload_left", "train"), drawn=True)
    session, told = simulated(wanted, tmp_path / "session")
    (found,) = session.runs
    support = found.info.support
    assert support is not None
    assert support != AWKWARD
    assert (found.info.motion, found.hint) == ("unload_left", "train")
    tried = [text for text in told if "another double support" in text]
    assert tried
    assert tried[-1] == (
        f"run 1 of 1 cannot be done there; trying another double support: {support}"
    )


def test_where_the_first_does_nothing_else_is_drawn(tmp_path: Path) -> None:
    wanted = plan(PlannedRun(EASY, "unload_right"), drawn=True)
    session, told = simulated(wanted, tmp_path / "drawn")
    asked, _ = simulated(replace(wanted, drawn=False), tmp_path / "asked")
    assert not any("another" in text for text in told)
    one, other = (made.folder / "run_001.mcap" for made in (session, asked))
    assert one.read_bytes() == other.read_bytes()


def test_a_double_support_that_was_asked_for_is_no_other(tmp_path: Path) -> None:
    with pytest.raises(UnreachableError, match="on its right foot alone"):
        simulated(plan(PlannedRun(AWKWARD, "unload_left"), drawn=False), tmp_path / "session")
