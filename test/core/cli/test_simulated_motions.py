"""`shoecal simulate --motions`: which runs are made, and that everything is recorded."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from scipy.spatial.transform import Rotation

from core.cli.conftest import Run
from shoecal_core import cli
from shoecal_core.planning.motion_sets import MOTION_SETS, STANDARD, UNLOADING
from shoecal_core.recording import schemas
from shoecal_core.recording.session import Session
from shoecal_core.recording.truth import read_truth
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.simulation.samples import HOLD_S

ROOT = Path(__file__).resolve().parents[3]
ODD = (
    ROOT / "test" / "data" / "robots" / "odd_biped.yaml",
    ROOT / "test" / "data" / "shoes" / "odd_shoe.yaml",
)
NAO = (ROOT / "config" / "robots" / "nao.yaml", ROOT / "config" / "shoes" / "nao_shoe.yaml")


def simulate(folder: Path, *words: object) -> dict[str, object]:
    """Make a session; what the command says of it."""
    figures = folder.with_name(f"{folder.name}.json")
    listed = ["simulate", *words, "--rate", "20", "--out", folder, "--json", figures]
    assert cli.main([str(word) for word in listed]) == 0
    found: dict[str, object] = json.loads(figures.read_text())
    return found


def messages_on(topic: str, run: Path) -> int:
    """How many messages of a topic a run's file holds."""
    with run.open("rb") as file:
        return sum(1 for _ in make_reader(file).iter_messages([topic]))


@pytest.fixture(scope="module")
def standard(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """The standard set, by the second robot."""
    folder = tmp_path_factory.mktemp("standard") / "session"
    simulate(folder, *ODD, "--motions", "standard", "--seed", "2")
    return Session.open(folder)


def test_the_standard_set_is_marked_and_tests_stand_elsewhere(standard: Session) -> None:
    runs = standard.runs
    assert tuple((run.info.motion, run.hint) for run in runs) == MOTION_SETS[STANDARD].runs
    places = {
        hint: {
            run.info.support
            for run in runs
            if run.hint == hint and run.info.motion not in UNLOADING
        }
        for hint in ("train", "test")
    }
    assert len(places["train"]) == 2
    assert len(places["test"]) == 3
    assert not places["train"] & places["test"]
    yaws = [support.dtheta for support in places["train"] | places["test"] if support]
    assert len(set(yaws)) == 5


def test_an_unloaded_foot_carries_nothing_for_a_while(standard: Session) -> None:
    for motion, foot in (("unload_left", 0), ("unload_right", 1)):
        (run,) = [one.run for one in standard.runs if one.info.motion == motion]
        truth = read_truth(standard.truth_path(run))
        free = truth.foot_grf[:, foot] <= 0.0
        assert float(np.mean(np.diff(truth.time))) * int(free.sum()) > 0.5
        edges = np.flatnonzero(np.diff(np.concatenate(([0], free.astype(int), [0]))))
        assert np.max(np.diff(edges)[::2]) / 20.0 > 0.5, "in one piece"
        # The other one has all of it meanwhile.
        assert truth.foot_grf[free, 1 - foot].mean() == pytest.approx(
            truth.grf[: len(free) // 8].mean(), rel=0.02
        )


def test_everything_a_diagnosis_needs_is_recorded(standard: Session) -> None:
    run = standard.read(1)
    assert run.imu is not None
    assert len(run.imu.time) == len(run.readings.time)
    up = Rotation.from_quat(run.imu.quaternion).apply(run.imu.linear_acceleration)
    assert up.mean(axis=0) == pytest.approx([0.0, 0.0, GRAVITY], abs=0.1)
    assert messages_on(schemas.JOINT_TEMPERATURES, run.path) > 0
    assert len(run.commanded) == 1
    assert run.commanded[0].start == pytest.approx(HOLD_S, abs=0.01)
    # The session's time goes on from run to run.
    starts = [standard.read(entry.run).start_ns for entry in standard.runs]
    assert np.all(np.diff(starts) > 1e9)


def test_what_the_reality_leaves_out_is_not_recorded(tmp_path: Path) -> None:
    reality = tmp_path / "mine.yaml"
    reality.write_text(
        "format: 1\nname: mine\nimu: {present: false}\nservo: {temperatures_told: false}\n"
    )
    folder = tmp_path / "session"
    told = simulate(
        folder, *ODD, "--motions", "faster,hold,faster", "--stance", "neutral", "wide",
        "--reality", reality,
    )  # fmt: skip
    session = Session.open(folder)
    assert [(run.info.motion, run.hint) for run in session.runs] == [
        ("faster", ""),
        ("hold", ""),
        ("faster", ""),
    ]
    assert session.runs[0].info.support == session.runs[2].info.support
    assert isinstance(told["runs"], list)
    assert [run["motion"] for run in told["runs"]] == ["faster", "hold", "faster"]
    run = session.read(1)
    assert run.imu is None
    assert messages_on(schemas.JOINT_TEMPERATURES, run.path) == 0


@pytest.mark.parametrize("listed", ["dance", "landmarks,", "standard,hold"])
def test_motions_that_there_are_not(shoecal: Run, tmp_path: Path, listed: str) -> None:
    with pytest.raises(SystemExit):
        shoecal("simulate", *NAO, "--motions", listed, "--out", tmp_path / "session")
    assert not (tmp_path / "session").exists()
