from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from core.recording import samples
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.columns import decode_columns
from shoecal_core.recording.container import read_container
from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.truth import Truth, TruthWriter, read_truth
from shoecal_core.recording.writer import RunWriter

NAN = np.nan
COP = np.array([[0.01, 0.02], [0.03, -0.1], [NAN, NAN]])
FOOT_COP = np.array([[[0.01, 0.02], [NAN, NAN]], [[NAN, NAN], [0.05, 0.01]], [[NAN] * 2] * 2])
FOOT_GRF = np.array([[50.0, 0.0], [0.5, 49.0], [0.0, 0.0]])


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "run_001.mcap"
    with TruthWriter(path, samples.INFO) as writer:
        for step in range(3):
            stamp = samples.START_NS + step * samples.STEP_NS
            writer.write(stamp, COP[step], FOOT_COP[step], FOOT_GRF[step])
    return path


def test_round_trip(path: Path) -> None:
    truth = read_truth(path)
    assert truth.start_ns == samples.START_NS
    np.testing.assert_allclose(truth.time, [0.0, 0.01, 0.02])
    np.testing.assert_array_equal(truth.cop, COP)
    np.testing.assert_array_equal(truth.foot_cop, FOOT_COP)
    np.testing.assert_array_equal(truth.foot_grf, FOOT_GRF)
    np.testing.assert_array_equal(truth.grf, [50.0, 49.5, 0.0])


def test_times_count_from_a_runs_start(path: Path) -> None:
    truth = read_truth(path, samples.START_NS - 10**9)
    np.testing.assert_allclose(truth.time, [1.0, 1.01, 1.02])


def test_torque_is_that_of_the_force_at_the_cop(tmp_path: Path) -> None:
    with TruthWriter(tmp_path / "run_001.mcap", samples.INFO) as writer:
        writer.write(5, [0.1, 0.2], [[0.1, 0.2], [NAN, NAN]], [40.0, 0.0])
    found = read_container(tmp_path / "run_001.mcap", schemas.TRUTH_TOPICS).messages
    (block,) = decode_columns(schemas.TRUTH_TOPICS[schemas.TRUTH_GRF], found[schemas.TRUTH_GRF])
    assert block.frame_id == "l_sole"
    torque = block.group("wrench.torque.x", "wrench.torque.y", "wrench.torque.z")
    np.testing.assert_allclose(torque, [[8.0, -4.0, 0.0]])
    assert schemas.TRUTH_FOOT_COP[1] not in found  # an unloaded foot has no CoP


def test_bad_truth_is_refused(tmp_path: Path) -> None:
    with TruthWriter(tmp_path / "run_001.mcap", samples.INFO) as writer:
        with pytest.raises(ShapeError, match=r"truth.foot_cop: expected shape \(1, 2, 2\)"):
            writer.write(0, [0, 0], [0, 0], [0, 0])
        with pytest.raises(ShoecalError, match=r"truth.foot_grf: infinite"):
            writer.write(0, [0, 0], np.zeros((2, 2)), [np.inf, 0])
    with pytest.raises(ShapeError, match=r"truth.cop"):
        Truth(0, np.zeros(2), np.zeros(2), np.zeros((2, 2, 2)), np.zeros((2, 2)))


def test_a_foot_without_force_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run_001.mcap"
    with RunWriter(path, samples.INFO, topics=schemas.TRUTH_TOPICS) as writer:
        left = messages.wrench(1, "l_sole", [0, 0, 1], [0, 0, 0])
        writer.write(schemas.TRUTH_FOOT_GRF[0], left, 1)
    with pytest.raises(RecordingError, match=r"/truth/right/grf: is missing"):
        read_truth(path)
