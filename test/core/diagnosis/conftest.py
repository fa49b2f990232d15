"""One simulated session for all tests of the diagnosis: the standard set, nothing wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from core.diagnosis.drawn import Urn
from shoecal_core import cli
from shoecal_core.diagnosis.baseline import first_parameters
from shoecal_core.diagnosis.candidates import possible_runs
from shoecal_core.diagnosis.forecast import PossibleRun
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.scene import make_scene
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording.session import Session
from shoecal_core.samples.sampling import load_samples

CONFIG = Path(__file__).resolve().parents[3] / "config"
CLEAN = """format: 1
name: clean
body: {weight_error_n: 0.0, mass_error_std_fraction: 0.0, com_error_std_m: 0.0, com_error_m: {}}
joints: {encoder_error_std_rad: 0.0, play_rad: {}, compliance_rad_per_nm: {}}
cells: {position_error_std_m: 0.0}
shoes: {clamp_share: {}}
"""


@pytest.fixture(scope="session")
def standard_session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """NAO as its model says on cells that are affine: runs 1 to 6 train, 7 and 8 test."""
    folder = tmp_path_factory.mktemp("diagnosis")
    reality = folder / "clean.yaml"
    reality.write_text(CLEAN)
    words = [
        "simulate", CONFIG / "robots" / "nao.yaml", CONFIG / "shoes" / "nao_shoe.yaml",
        "--reality", reality, "--motions", "standard", "--rate", "50", "--seed", "4",
        "--out", folder / "session",
    ]  # fmt: skip
    assert cli.main([str(word) for word in words]) == 0
    return Session.open(folder / "session")


@pytest.fixture(scope="session")
def workspace(standard_session: Session) -> Workspace:
    """Every effect laid out in that session."""
    settings = DiagnosisSettings()
    samples = load_samples(standard_session, range(1, 9), settings)
    train, test = range(1, 7), (7, 8)
    scene = make_scene(samples, first_parameters(samples, train), settings)
    return make_workspace(scene, EFFECTS, train, test, settings)


@pytest.fixture(scope="session")
def runs(workspace: Workspace) -> tuple[PossibleRun, ...]:
    """Every motion that could be run next."""
    return possible_runs(workspace.scene, PlannerSettings())


@pytest.fixture(scope="session")
def urn(workspace: Workspace) -> Urn:
    """Draws sessions with that layout."""
    return Urn.of(workspace)
