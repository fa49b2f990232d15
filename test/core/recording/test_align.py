from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError
from shoecal_core.recording.align import interpolate_joints
from shoecal_core.recording.run import JointSamples


def samples(time: list[float], position: list[list[float]]) -> JointSamples:
    names = tuple("abc"[: len(position[0])])
    return JointSamples(np.array(time), names, np.array(position), None)


def lines(time: FloatArray) -> FloatArray:
    return np.column_stack([1.0 + 2.0 * time, -3.0 * time])


@given(
    st.lists(st.integers(0, 1000), min_size=2, max_size=30, unique=True).map(sorted),
    st.lists(st.floats(-1.0, 11.0), max_size=30),
    st.floats(-0.5, 0.5),
)
def test_straight_lines_are_met_exactly(ticks: list[int], wanted: list[float], late: float) -> None:
    time = np.array(ticks) / 100.0
    joints = JointSamples(time, ("a", "b"), lines(time), None)
    times = np.array(wanted)
    position, valid = interpolate_joints(joints, times, 100.0, late_s=late)
    shifted = times + late
    np.testing.assert_array_equal(valid, (shifted >= time[0]) & (shifted <= time[-1]))
    np.testing.assert_allclose(position[valid], lines(shifted)[valid], atol=1e-9)
    assert np.isnan(position[~valid]).all()


def test_gaps_are_not_bridged_but_their_ends_count() -> None:
    joints = samples([0.0, 0.1, 0.5, 0.6], [[0.0], [1.0], [5.0], [6.0]])
    position, valid = interpolate_joints(joints, np.array([0.05, 0.1, 0.3, 0.5, 0.55, 0.6]), 0.1001)
    assert valid.tolist() == [True, True, False, True, True, True]
    np.testing.assert_allclose(position[valid, 0], [0.5, 1.0, 5.0, 5.5, 6.0])


def test_joints_told_apart_are_interpolated_apart() -> None:
    nan = np.nan
    joints = samples(
        [0.0, 0.1, 0.2, 0.3], [[0.0, nan, nan], [nan, 1.0, nan], [2.0, nan, nan], [nan, 3.0, nan]]
    )
    position, valid = interpolate_joints(joints, np.array([0.1, 0.15]), 0.25, names=("b", "a"))
    assert valid.tolist() == [True, True]
    np.testing.assert_allclose(position, [[1.0, 1.0], [1.5, 1.5]])
    _, valid = interpolate_joints(joints, np.array([0.1]), 0.25)
    assert valid.tolist() == [False]  # c was never recorded


def test_one_sample_is_met_only_at_its_time() -> None:
    _, valid = interpolate_joints(samples([1.0], [[2.0]]), np.array([0.9, 1.0, 1.1, np.nan]), 1.0)
    assert valid.tolist() == [False, True, False, False]


def test_unknown_joint_is_named() -> None:
    with pytest.raises(NameNotFoundError, match=r"no recorded joint named 'x' \(there are: a\)"):
        interpolate_joints(samples([1.0], [[2.0]]), np.array([1.0]), 1.0, names=("x",))
