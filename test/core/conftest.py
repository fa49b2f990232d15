"""What tests of the core share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from core.diagnosis.drawn import Urn
from core.estimation import synthetic
from core.shoe import shoes
from shoecal_core import cli
from shoecal_core.diagnosis.baseline import first_parameters
from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.diagnosis.workspace import Workspace, make_workspace
from shoecal_core.error_sources.effects.known import EFFECTS
from shoecal_core.error_sources.signal_model import make_signal_model
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.session_data import load_data
from shoecal_core.recording.session import Session
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters

CONFIG = Path(__file__).resolve().parents[2] / "config"
CLEAN = """format: 1
name: clean
body: {weight_error_n: 0.0, mass_error_std_fraction: 0.0, com_error_std_m: 0.0, com_error_m: {}}
joints: {encoder_error_std_rad: 0.0, play_rad: {}, compliance_rad_per_nm: {}}
cells: {position_error_std_m: 0.0}
shoes: {clamp_share: {}}
"""


@pytest.fixture(params=shoes.NAMES)
def shoe(request: pytest.FixtureRequest) -> Shoe:
    """Both shoes."""
    return shoes.shoe(request.param)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20)


@pytest.fixture
def truth(shoe: Shoe, rng: np.random.Generator) -> ChannelParameters:
    return synthetic.truth(shoe, rng)


@pytest.fixture(scope="session")
def standard_session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """NAO as its model says on cells that are affine: runs 1 to 6 train, 7 and 8 test."""
    folder = tmp_path_factory.mktemp("diagnosis")
    reality = folder / "clean.yaml"
    reality.write_text(CLEAN)
    words = [
        "simulate", CONFIG / "robots" / "nao.yaml", CONFIG / "shoes" / "nao_shoe.yaml",
        "--reality", reality, "--supports", "5", "--rate", "50", "--seed", "2", "--motions",
        "landmarks,reversed,faster,torso_height,unload_left,unload_right,landmarks,reversed",
        "--out", folder / "session",
    ]  # fmt: skip
    assert cli.main([str(word) for word in words]) == 0
    return Session.open(folder / "session")


@pytest.fixture(scope="session")
def workspace(standard_session: Session) -> Workspace:
    """Every effect laid out in that session."""
    settings = DiagnosisSettings()
    samples = load_data(standard_session, range(1, 9)).whole_samples(settings)
    train, test = range(1, 7), (7, 8)
    signal_model = make_signal_model(samples, first_parameters(samples, train), settings)
    return make_workspace(signal_model, EFFECTS, train, test, settings, Tolerances())


@pytest.fixture(scope="session")
def urn(workspace: Workspace) -> Urn:
    """Draws sessions with that layout."""
    return Urn.of(workspace)
