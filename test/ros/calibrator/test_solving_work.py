"""What the calibrator's worker solves: the fit of the command, with the same prior."""

from __future__ import annotations

import re
import shutil
from multiprocessing import Pipe
from pathlib import Path

import numpy as np
import pytest
import yaml

from ros.bodies import NAO, NAO_SHOE
from shoecal_core import cli
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.calibration import load_calibration
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_ros.calibrator import job_work
from shoecal_ros.common.worker import Link


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorded session, and a manual calibration of such shoes."""
    folder = tmp_path_factory.mktemp("solving")
    session = ["simulate", NAO, NAO_SHOE, "--motions", "standard", "--rate", "50"]
    for words in (
        [*session, "--seed", "4", "--out", folder / "session"],
        ["manual", "simulate", "--seed", "4", "--out", folder / "bench"],
    ):
        assert cli.main([str(word) for word in words]) == 0
    return folder


def test_a_manual_calibration_is_the_prior_of_the_fit(folder: Path) -> None:
    settings, tolerances, session = CalibrationSettings(), Tolerances(), folder / "session"
    manual = load_calibration(folder / "bench" / "calibration.yaml")
    link = Link(Pipe()[1])
    alone, with_prior = (
        job_work.solve(link, session, settings, tolerances, 10**18, prior)
        for prior in (None, manual)
    )
    assert not np.array_equal(alone.parameters.gain, with_prior.parameters.gain)
    words = ["calibrate", session, "--manual", folder / "bench" / "calibration.yaml"]
    out = folder / "by_command.yaml"
    assert cli.main([str(word) for word in (*words, "--out", out)]) in {0, 1, 2}
    by_command = load_calibration(out)
    np.testing.assert_allclose(with_prior.parameters.gain, by_command.parameters.gain, rtol=1e-9)
    kept = load_calibration(session / job_work.CALIBRATION)
    np.testing.assert_array_equal(kept.parameters.gain, with_prior.parameters.gain)


def shortened(folder: Path, count: int, into: Path) -> Path:
    """The session as it was after so many of its runs."""
    shutil.copytree(folder, into)
    for later in sorted(into.glob("run_*.mcap"))[count:]:
        later.unlink()
    index = yaml.safe_load((into / "session.yaml").read_text())
    index["runs"] = index["runs"][:count]
    (into / "session.yaml").write_text(yaml.safe_dump(index))
    return into


def test_each_run_brings_the_feet_nearer_to_a_target(folder: Path, tmp_path: Path) -> None:
    settings, tolerances, link = CalibrationSettings(), Tolerances(), Link(Pipe()[1])

    def reached(count: int) -> job_work.Reached:
        session = shortened(folder / "session", count, tmp_path / str(count))
        return job_work.reached(link, session, settings, tolerances, None)

    one, two, three, four = (reached(count) for count in (1, 2, 3, 4))
    assert one.cop == two.cop == np.inf
    assert "no calibration yet: " in one.message
    assert "record at least 2" in one.message
    assert 0.010 > three.cop > four.cop > 0.001
    said = re.search(r"of a foot ([\d.]+) mm; .* would make that ([\d.]+) mm", four.message)
    assert said
    now, then = map(float, said.groups())
    assert now == pytest.approx(1e3 * four.cop, abs=0.06)
    assert 0.5 * now < then <= now
