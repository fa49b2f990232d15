from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from builtin_interfaces.msg import Duration
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rclpy.serialization import deserialize_message, serialize_message
from shoecal_msgs.msg import ShoeCalibration, ShoeVoltages
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from ros.bodies import calibration, nao, nao_shoe
from shoecal_core.errors import ShoecalError
from shoecal_core.robot.double_support import FARTHEST_M, DoubleSupport
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.shoe.correction import CopCorrection
from shoecal_ros.common import conversions
from shoecal_ros.common.conversions import JointSample, MessageError
from shoecal_ros.common.origin import Origin
from shoecal_ros.common.voltage_frame import VoltageFrame

STAMPS = st.integers(0, 2**31 * 10**9 - 1)
NUMBERS = st.floats(-1e6, 1e6)
PLACES = st.floats(-FARTHEST_M, FARTHEST_M)
NAMES = st.lists(st.text("abcxyz_/", min_size=1, max_size=12), min_size=1, max_size=8, unique=True)


def sent(message: object) -> object:
    """A message after its way over the wire."""
    return deserialize_message(serialize_message(message), type(message))


@given(STAMPS)
def test_times_come_back(stamp_ns: int) -> None:
    assert conversions.time_from_ros(conversions.time_to_ros(stamp_ns)) == stamp_ns


@given(st.floats(0.0, 1e6))
def test_durations_come_back_to_the_nanosecond(seconds: float) -> None:
    duration = conversions.duration_to_ros(seconds)
    assert isinstance(duration, Duration)
    assert conversions.time_from_ros(duration) == round(seconds * 1e9)


@given(STAMPS, NAMES, st.data())
def test_joints_come_back(stamp_ns: int, names: list[str], data: st.DataObject) -> None:
    some = arrays(np.float64, len(names), elements=NUMBERS)
    sample = JointSample(stamp_ns, tuple(names), data.draw(some), data.draw(st.none() | some))
    found: Any = sent(conversions.joints_to_ros(sample))
    assert conversions.time_from_ros(found.header.stamp) == sample.stamp_ns
    assert tuple(found.name) == sample.names
    np.testing.assert_array_equal(found.position, sample.position)
    np.testing.assert_array_equal(found.effort, () if sample.effort is None else sample.effort)


@given(STAMPS, NAMES, st.integers(0, 2**32 - 1), st.data())
def test_voltages_come_back(
    stamp_ns: int, cells: list[str], sequence: int, data: st.DataObject
) -> None:
    count = len(cells)
    frame = VoltageFrame(
        stamp_ns=stamp_ns,
        source="driver",
        sequence=sequence,
        cells=tuple(cells),
        voltage=data.draw(arrays(np.float64, count, elements=NUMBERS | st.just(math.nan))),
        status=data.draw(arrays(np.uint8, count, elements=st.integers(0, 3))),
        temperature=data.draw(NUMBERS | st.just(math.nan)),
    )
    found = conversions.voltages_from_ros(sent(conversions.voltages_to_ros(frame)))
    assert (found.stamp_ns, found.source, found.sequence, found.cells) == (
        stamp_ns, "driver", sequence, tuple(cells),
    )  # fmt: skip
    np.testing.assert_array_equal(found.voltage, frame.voltage)
    np.testing.assert_array_equal(found.status, frame.status)
    np.testing.assert_equal(found.temperature, frame.temperature)


def test_voltages_that_contradict_themselves_are_refused() -> None:
    with pytest.raises(MessageError, match="1 voltages and 2 statuses for 2 cells"):
        conversions.voltages_from_ros(ShoeVoltages(cell=["a", "b"], voltage=[0.0], status=[0, 0]))


@given(PLACES, PLACES, st.floats(-math.tau, math.tau))
def test_supports_come_back(dx: float, dy: float, dtheta: float) -> None:
    support = DoubleSupport(dx, dy, dtheta)
    assert conversions.support_from_ros(sent(conversions.support_to_ros(support))) == support


def test_a_support_that_is_no_place_is_refused() -> None:
    message = conversions.support_to_ros(DoubleSupport(0.0, -0.1, 0.0))
    message.dx = math.nan
    with pytest.raises(ShoecalError, match="finite"):
        conversions.support_from_ros(message)


@given(st.integers(1, 5), st.integers(1, 4), st.data())
def test_trajectories_come_back(points: int, joints: int, data: st.DataObject) -> None:
    steps = data.draw(st.lists(st.integers(1, 10**9), min_size=points, max_size=points))
    trajectory = JointTrajectory(
        tuple(f"joint_{index}" for index in range(joints)),
        np.cumsum(steps) / 1e9,
        data.draw(arrays(np.float64, (points, joints), elements=NUMBERS)),
    )
    message = sent(conversions.trajectory_to_ros(trajectory, 7))
    found = conversions.trajectory_from_ros(message)
    assert found.names == trajectory.names
    np.testing.assert_allclose(found.times, trajectory.times, rtol=0.0, atol=1e-9)
    np.testing.assert_array_equal(found.positions, trajectory.positions)


def test_a_trajectory_without_points_is_refused() -> None:
    with pytest.raises(MessageError, match="0 points"):
        conversions.trajectory_from_ros(JointTrajectoryMsg(joint_names=["a"]))


@given(STAMPS, st.lists(NUMBERS, min_size=2, max_size=3))
def test_points_come_back(stamp_ns: int, point: list[float]) -> None:
    message = sent(conversions.point_to_ros(stamp_ns, "l_sole", point))
    expected = [*point, 0.0][:3]
    assert conversions.point_from_ros(message).tolist() == expected


@given(STAMPS, st.lists(NUMBERS, min_size=3, max_size=3))
def test_wrenches_come_back(stamp_ns: int, wrench: list[float]) -> None:
    message: Any = sent(conversions.wrench_to_ros(stamp_ns, "l_sole", wrench))
    found = message.wrench
    assert [found.force.z, found.torque.x, found.torque.y] == wrench


def correction(foot: int, channels: int) -> CopCorrection:
    rng = np.random.default_rng(foot)
    return CopCorrection(
        foot=foot,
        x=rng.normal(size=4 + channels),
        y=rng.normal(size=4 + channels),
        cop_range=np.sort(rng.normal(size=(2, 2)), axis=0),
        output_range=np.sort(rng.normal(size=(2, channels)), axis=0),
    )


@pytest.mark.parametrize("feet", [(), (0,), (1,), (0, 1)])
@pytest.mark.parametrize("known", [False, True])
def test_calibrations_come_back(feet: tuple[int, ...], known: bool) -> None:
    shoe = nao_shoe()
    count = 2 * len(shoe.names)
    rng = np.random.default_rng(1)
    original = calibration(
        nao(),
        shoe,
        corrections=tuple(correction(foot, 4) for foot in feet),
        covariance=rng.normal(size=(count, count)) if known else None,
        temperature=21.5 if known else math.nan,
        verdict="WARN",
        reasons=("one", "two"),
        fitted_runs=("ab", "cd"),
        columns=rng.normal(size=(len(shoe.names), 3)) if known else None,
        column_covariance=rng.normal(size=(3 * count // 2, 5 * count // 2)) if known else None,
        support_covariance=rng.normal(size=(3, 3)) if known else None,
    )
    found = conversions.calibration_from_ros(sent(conversions.calibration_to_ros(original)))
    for name in ("id", "source", "made_ns", "robot", "shoe", "robot_hash", "shoe_hash",
                 "channels", "weight", "time_offset", "verdict", "reasons",
                 "fitted_runs"):  # fmt: skip
        assert getattr(found, name) == getattr(original, name)
    np.testing.assert_equal(found.temperature, original.temperature)
    np.testing.assert_array_equal(found.parameters.gain, original.parameters.gain)
    np.testing.assert_array_equal(found.parameters.offset, original.parameters.offset)
    for name in ("columns", "covariance", "column_covariance", "support_covariance"):
        if known:
            np.testing.assert_array_equal(getattr(found, name), getattr(original, name))
        else:
            assert getattr(found, name) is None
    assert [one.foot for one in found.corrections] == list(feet)
    for one, other in zip(found.corrections, original.corrections, strict=True):
        for part in ("x", "y", "cop_range", "output_range"):
            np.testing.assert_array_equal(getattr(one, part), getattr(other, part))


def test_the_origin_of_a_calibration_comes_back() -> None:
    made, origin = (
        calibration(nao(), nao_shoe()),
        Origin(simulated=False, host="lab", device="shoe_driver"),
    )
    message = sent(conversions.calibration_to_ros(made, origin))
    assert conversions.origin_from_ros(message) == origin
    assert not conversions.origin_from_ros(conversions.calibration_to_ros(made)).simulated
    early = conversions.calibration_to_ros(calibration(nao(), nao_shoe(), made_ns=10**11))
    assert early.simulated_time
    assert conversions.origin_from_ros(early).simulated
    # Nobody is believed against the stamp.
    early.simulated_time = False
    with pytest.raises(MessageError, match="before the year 2000"):
        conversions.origin_from_ros(early)


def test_a_calibration_of_another_layout_is_refused() -> None:
    message = conversions.calibration_to_ros(calibration(nao(), nao_shoe()))
    message.format = 2
    with pytest.raises(MessageError, match="one version"):
        conversions.calibration_from_ros(message)


def test_a_calibration_with_half_a_covariance_is_refused() -> None:
    for field in ("covariance", "column_covariance", "support_covariance"):
        message = conversions.calibration_to_ros(calibration(nao(), nao_shoe()))
        setattr(message, field, [1.0, 2.0])
        with pytest.raises(ShoecalError, match=field):
            conversions.calibration_from_ros(message)


def test_an_empty_calibration_is_refused() -> None:
    with pytest.raises(ShoecalError):
        conversions.calibration_from_ros(ShoeCalibration(format=1))
