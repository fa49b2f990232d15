"""Six-axis sensors whose vertical force shows a part of their moments."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from shoecal_core import cli
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.outcome import CalibrationOutcome
from shoecal_core.estimation.run_errors import errors_by_set
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import Session
from shoecal_core.shoe.wrench import foot_wrenches
from shoecal_core.workflows.calibrate import calibrate_session
from shoecal_core.workflows.evaluation import MEASURED, TRUTH, compare_data
from shoecal_core.workspace import config_dir

COUPLED = (("left/fz", "left/mx", 1.0), ("right/fz", "right/my", -1.0))
"""1/m: of the moment about x in the left vertical force, and against that about y in the right. At
half of it the CoP's other errors can hide what it adds."""


class Coupled(Session):
    """A session whose sensors have crosstalk, that part of `COUPLED`."""

    part = 1.0

    def read(self, run: int) -> Run:
        """With a part of each donor's reading in the receiver's, gains of data sheets at hand."""
        recorded = super().read(run)
        value, names = recorded.readings.value.copy(), self.shoe.names
        for receiver, donor, part in COUPLED:
            value[:, names.index(receiver)] += self.part * part * value[:, names.index(donor)]
        return replace(recorded, readings=replace(recorded.readings, value=value))


class Weakly(Coupled):
    """With half of it."""

    part = 0.5


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    """Of the little robot on six-axis sensors in its ankles."""
    folder = tmp_path_factory.mktemp("crosstalk")
    robot, out = folder / "robot.yaml", folder / "session"
    urdf = config_dir() / "robots" / "wren.urdf"
    words = ["new", "robot", urdf, "--six-axis", "-o", robot]
    assert cli.main([str(word) for word in words]) == 0
    words = [
        "simulate",
        robot,
        folder / "robot_shoe.yaml",
        "--supports",
        5,
        "--seed",
        2,
        "--out",
        out,
    ]
    words += ["--reality", folder / "robot_reality.yaml"]
    assert cli.main([str(word) for word in words]) == 0
    return Coupled.open(out)


def cop_error(session: Session, outcome: CalibrationOutcome) -> float:
    """Of both feet, against the truth [m]."""
    measuring = {MEASURED: outcome.calibration.sensing(session.shoe)}
    runs = compare_data(session, outcome.data, {"train": outcome.train}, measuring)
    return errors_by_set(runs, MEASURED, TRUTH)["train"].cop.mean


def test_crosstalk_is_found_and_taken_off(session: Session) -> None:
    known, unknown = (
        calibrate_session(session, tolerances=Tolerances(crosstalk=part)) for part in (0.01, 0.0)
    )
    assert known.calibration.verdict == "PASS", known.calibration.reasons
    assert cop_error(session, known) < 0.8 * cop_error(session, unknown)
    assert known.joint is not None
    found = {one.deviation.location: one for one in known.joint.deviations
             if one.deviation.effect == "crosstalk"}  # fmt: skip
    for receiver, donor, part in COUPLED:
        one = found[receiver, donor]
        assert one.value == pytest.approx(part, abs=3.0 * one.std)
        # The fitted columns take off what the receiver shows too much of any donor's output.
        names = session.shoe.names
        outputs = np.random.default_rng(2).normal(size=(5, len(names)))
        shown = outputs.copy()
        shown[:, names.index(receiver)] += one.value * outputs[:, names.index(donor)]
        change = one.deviation.shoe_column
        assert change is not None
        fitted = session.shoe.with_columns(session.shoe.columns + one.value * change)
        np.testing.assert_allclose(
            foot_wrenches(fitted, shown), foot_wrenches(session.shoe, outputs), atol=1e-9
        )
        assert fitted.vertical.tolist() == session.shoe.vertical.tolist()


def test_parts_of_moments_are_expected_as_they_are_without(
    session: Session,
) -> None:
    """How channels share a load does not change by what a sensor shows of it."""
    coupled = calibrate_session(Weakly.open(session.folder))
    clean = calibrate_session(Session.open(session.folder))
    there, here = (outcome.assessment.expected_cop()[0] for outcome in (coupled, clean))
    assert there == pytest.approx(here, rel=0.6)
