from __future__ import annotations

from collections.abc import Sequence
from multiprocessing import Pipe
from pathlib import Path

import pytest

from ros.bodies import NAO, NAO_SHOE, nao
from shoecal_core.planning.motion_sets import MOTION_SETS, THOROUGH, PlannedRun
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.calibrator import job_work
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.worker import Link

SUPPORTS = (DoubleSupport(0.0, -0.112, 0.0), DoubleSupport(0.01, -0.115, 0.25))


def runs(motions: Sequence[str], session: Path | None = None) -> list[PlannedRun]:
    files = RobotFiles(str(NAO), str(NAO_SHOE))
    return job_work.runs_to_record(Link(Pipe()[1]), files, PlannerSettings(), motions, 1, session)


@pytest.fixture
def session(tmp_path: Path) -> Path:
    """With two runs, the first to test, in different supports."""
    made = Session.create(tmp_path / "session", nao().path, nao().urdf, NAO_SHOE)
    for support, hint in zip(SUPPORTS, ("test", "train"), strict=True):
        made.new_run("landmarks", support, hint=hint).close()
    return made.folder


def test_without_motions_it_is_the_thorough_set() -> None:
    found = runs(())
    assert tuple((run.motion, run.hint) for run in found) == MOTION_SETS[THOROUGH].runs


@pytest.mark.parametrize(
    ("motions", "hints"),
    [
        (("landmarks", "hold"), ("", "")),
        (("landmarks", "hold", "faster"), ("train", "train", "test")),
    ],
)
def test_listed_motions_in_drawn_supports(motions: tuple[str, ...], hints: tuple[str, ...]) -> None:
    found = runs(motions)
    assert tuple(run.motion for run in found) == motions
    assert tuple(run.hint for run in found) == hints
    assert len({run.support for run in found}) == len(motions)


def test_what_is_added_to_a_session_trains_in_its_own_supports(session: Path) -> None:
    found = runs(("unload_left", "warm_up", "turn_180"), session)
    assert [run.support for run in found] == [SUPPORTS[1], SUPPORTS[0], SUPPORTS[1]]
    assert {run.hint for run in found} == {"train"}
    assert [run.motion for run in found] == ["unload_left", "warm_up", "turn_180"]


def test_beside_runs_without_marks_what_is_added_has_none(session: Path) -> None:
    Session.open(session).mark((), ())
    (run,) = runs(("unload_left",), session)
    assert run == PlannedRun(SUPPORTS[0], "unload_left", "")


def test_a_yawed_stance_is_far_from_those_so_far(session: Path) -> None:
    (run,) = runs(("yawed_stance",), session)
    assert run.motion == "yawed_stance"
    assert run.support.dtheta < -0.2
    for support in SUPPORTS:
        assert abs(run.support.dtheta - support.dtheta) > 0.2
