from __future__ import annotations

import numpy as np
import pytest

from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.recording.run import JointSamples, PoseSamples, TemperatureSamples


def test_shapes_are_checked() -> None:
    with pytest.raises(ShapeError, match=r"joints.position: expected shape \(2, 1\), got \(2, 2\)"):
        JointSamples(np.array([0.0, 1.0]), ("a",), np.zeros((2, 2)), None)
    with pytest.raises(ShapeError, match=r"joints.effort"):
        JointSamples(np.array([0.0]), ("a",), np.zeros((1, 1)), np.zeros((2, 1)))
    with pytest.raises(ShapeError, match=r"base_pose.quaternion"):
        PoseSamples(np.array([0.0]), np.zeros((1, 3)), np.zeros((1, 3)))


@pytest.mark.parametrize("time", [[0.0, 0.0], [1.0, 0.0], [0.0, np.nan], [0.0, np.inf]])
def test_time_must_increase(time: list[float]) -> None:
    with pytest.raises(ShoecalError, match="must be finite and increase"):
        TemperatureSamples(np.array(time), np.zeros(2))


def test_something_must_be_there() -> None:
    with pytest.raises(ShapeError, match="T > 0"):
        TemperatureSamples(np.empty(0), np.empty(0))


def test_rates_are_those_of_samples_not_of_packets() -> None:
    """Four samples each 40 ms arrive at once: 100 Hz, whatever gap is in the recording."""
    packets = 0.04 * np.arange(100)[:, None] + [0.0, 0.001, 0.002, 0.003]
    packets[50:] += 30.0
    time = packets.ravel()
    joints = JointSamples(time, ("a",), np.zeros((400, 1)), None)
    assert joints.rate_hz == pytest.approx(100.0, rel=0.02)
