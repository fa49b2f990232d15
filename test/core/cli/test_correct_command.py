"""Corrected files of a robot are nearer to a robot than those it was drawn from."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import mujoco
import pytest

from core.cli.conftest import ROOT, WREN, WREN_SHOE, Run
from shoecal_core import cli
from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.estimation.run_errors import errors_by_set
from shoecal_core.recording.session import Session
from shoecal_core.robot.randomisation import load_randomisation
from shoecal_core.robot.urdf import read_urdf
from shoecal_core.workflows.evaluation import evaluate_session
from shoecal_core.workflows.model_correction import corrected_files

PERFECT = ROOT / "config" / "realities" / "perfect.yaml"


@pytest.fixture(scope="module")
def sessions(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """Of one robot: one to correct its files by, and one of other double supports."""
    folder = tmp_path_factory.mktemp("correct")
    for name, seed, supports in (("fitted", 6, 8), ("new", 96, 3)):
        words = ["simulate", WREN, WREN_SHOE, "--supports", supports, "--seed", seed]
        words += ["--robot-seed", 6, "--rate", 50, "--out", folder / name]
        assert cli.main([str(word) for word in words]) == 0
    return folder / "fitted", folder / "new"


def test_the_corrected_model_is_nearer_to_the_truth_of_new_runs(
    shoecal: Run, sessions: tuple[Path, Path], tmp_path: Path
) -> None:
    fitted, new = sessions
    out, figures = tmp_path / "corrected", tmp_path / "figures.json"
    spec = mujoco.MjSpec.from_file(str(fitted / "robot.urdf"))
    spec.compiler.fusestatic = False
    spec.worldbody.first_body().add_freejoint()
    mass = spec.compile().body_mass.sum()
    (tmp_path / "lab.xml").write_text(spec.to_xml())
    code, told, _ = shoecal(
        "correct", fitted, "--mjcf", tmp_path / "lab.xml", "--out", out, "--json", figures
    )
    assert code == 0
    assert "on runs that were not fitted" in told
    found = json.loads(figures.read_text())
    assert found["after"]["cop_mae_mm"] < found["before"]["cop_mae_mm"]
    assert found["runs"] == list(range(1, 9))
    names = {one["effect"] for one in found["changes"]}
    assert names == {"joint_offset", "link_mass", "link_com"}
    assert_randomised(out, fitted, found["changes"])
    model = mujoco.MjModel.from_xml_path(str(out / "robot.xml"))
    assert model.body_mass.sum() == pytest.approx(mass, rel=1e-6)

    assert shoecal("calibrate", fitted, "--out", tmp_path / "c.yaml")[0] == 0
    calibration = load_calibration(tmp_path / "c.yaml")
    shutil.copytree(new, tmp_path / "again")
    for file in out.iterdir():
        shutil.copy(file, tmp_path / "again" / file.name)
    errors = []
    for folder in (new, tmp_path / "again"):
        evaluated = evaluate_session(Session.open(folder, force=True), calibration)
        (against,) = errors_by_set(evaluated.runs, "modelled", "truth").values()
        errors.append(against.cop.mean)
    assert errors[1] < 0.95 * errors[0]


def assert_randomised(out: Path, session: Path, changes: list[dict[str, object]]) -> None:
    """Means are what the corrected files have more than the nominal ones."""
    randomised = load_randomisation(out / "randomisation.yaml")
    before, after = (read_urdf(folder / "robot.urdf").model for folder in (session, out))
    for name, one in randomised.of("mass").items():
        joint = before.frames[before.getFrameId(name)].parentJoint
        change = after.inertias[joint].mass - before.inertias[joint].mass
        assert one.mean == pytest.approx(change, abs=1e-9)
        assert 0.0 <= one.std < 0.2  # too light to be fitted: zero
    thigh = before.frames[before.getFrameId("left_thigh")]
    moved = after.inertias[thigh.parentJoint].lever - before.inertias[thigh.parentJoint].lever
    turned = thigh.placement.rotation.T @ moved
    found = [randomised.of(f"com_{axis}")["left_thigh"].mean for axis in "xyz"]
    assert found == pytest.approx(list(turned), abs=1e-9)
    zeros = randomised.of("joint_zero")
    wanted = {
        one["location"][0]: (one["value"], one["std"])  # type: ignore[index]
        for one in changes
        if one["effect"] == "joint_offset"
    }
    assert {name: (one.mean, one.std) for name, one in zeros.items()} == wanted


@pytest.mark.parametrize(
    ("mesh", "told"),
    [("meshes/beak.stl", True), ("package://wren/beak.stl", False), ("/opt/beak.stl", False)],
)
def test_meshes_that_a_copy_does_not_find_are_told(
    mesh: str, told: bool, sessions: tuple[Path, Path], tmp_path: Path
) -> None:
    session = tmp_path / "session"
    shutil.copytree(sessions[1], session)
    shape = f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>'
    urdf = session / "robot.urdf"
    urdf.write_text(urdf.read_text().replace("</link>", f"{shape}</link>", 1))
    left = corrected_files(Session.open(session, force=True), ()).left
    assert [mesh in one and "copy it next to" in one for one in left] == [True] * told


def test_files_that_gain_nothing_stay(shoecal: Run, tmp_path: Path) -> None:
    session, out = tmp_path / "session", tmp_path / "out"
    words = ["simulate", WREN, WREN_SHOE, "--supports", "4", "--reality", PERFECT]
    assert shoecal(*words, "--rate", 50, "--out", session)[0] == 0
    code, _, error = shoecal("correct", session, "--out", out)
    assert code == 1
    assert "no joint zero and no mass" in error
    assert not out.exists()
