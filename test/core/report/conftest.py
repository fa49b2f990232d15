from __future__ import annotations

import pytest

from core.report import samples
from core.report.pages import read
from core.report.sessions import swaying_session
from core.shoe import shoes
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.recording.session import Session
from shoecal_core.report.calibration.content import CalibrationReport
from shoecal_core.report.calibration.report import calibration_page
from shoecal_core.report.html import render
from shoecal_core.workflows.calibrate import calibrate_session


@pytest.fixture(scope="session")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Two training runs and a test, with joint angles."""
    return swaying_session(tmp_path_factory.mktemp("session") / "recorded")


@pytest.fixture(scope="session")
def outcome(session: Session) -> CalibrationOutcome:
    """Its calibration."""
    return calibrate_session(session)


@pytest.fixture(scope="session")
def content() -> CalibrationReport:
    """The NAO's own shoes, with a truth, two runs."""
    return samples.content(shoes.shoe("nao_shoe"), runs=2)


@pytest.fixture(scope="session")
def small() -> CalibrationReport:
    """One run, no truth: the fewest figures."""
    return samples.content(shoes.shoe("nao_shoe"), runs=1, truth=False)


@pytest.fixture(scope="session")
def small_html(small: CalibrationReport) -> str:
    """The page of the small one."""
    return render(calibration_page(small))


@pytest.fixture(scope="session")
def text(content: CalibrationReport) -> str:
    """What the report tells."""
    return read(render(calibration_page(content))).text
