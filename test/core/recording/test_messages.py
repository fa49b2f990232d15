from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from rosbags.typesys.stores import ros2_jazzy as ros

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError, ShoecalError
from shoecal_core.recording import messages, schemas
from shoecal_core.recording.messages import series

stamps = st.integers(0, 2**31 * 10**9 - 1)
floats = st.floats(width=64)


def decode(data: bytes, type_name: str) -> object:
    return schemas.typestore().deserialize_cdr(data, type_name)


@given(stamps, st.lists(st.tuples(st.text("abc_1", min_size=1), floats, floats), max_size=9))
def test_joint_state_round_trip(stamp: int, joints: list[tuple[str, float, float]]) -> None:
    names = [name for name, _, _ in joints]
    position, effort = [p for _, p, _ in joints], [e for _, _, e in joints]
    back = decode(
        messages.joint_state(stamp, names, position, effort), "sensor_msgs/msg/JointState"
    )
    assert isinstance(back, ros.sensor_msgs__msg__JointState)
    assert back.header.stamp.sec * 10**9 + back.header.stamp.nanosec == stamp
    assert back.name == names
    np.testing.assert_array_equal(back.position, position)
    np.testing.assert_array_equal(back.effort, effort)


def test_trajectory_round_trip() -> None:
    position = np.arange(6.0).reshape(3, 2)
    data = messages.joint_trajectory(5, ("a", "b"), [0.0, 0.25, 1.9999999999], position)
    back = decode(data, "trajectory_msgs/msg/JointTrajectory")
    assert isinstance(back, ros.trajectory_msgs__msg__JointTrajectory)
    assert back.joint_names == ["a", "b"]
    np.testing.assert_array_equal([point.positions for point in back.points], position)
    times = [point.time_from_start for point in back.points]
    assert [(time.sec, time.nanosec) for time in times] == [(0, 0), (0, 250_000_000), (2, 0)]


def test_wrench_and_pose_round_trip() -> None:
    back = decode(messages.wrench(7, "f", [1, 2, 3], [4, 5, 6]), "geometry_msgs/msg/WrenchStamped")
    assert isinstance(back, ros.geometry_msgs__msg__WrenchStamped)
    assert (back.wrench.force.z, back.wrench.torque.x, back.header.frame_id) == (3.0, 4.0, "f")
    back = decode(messages.pose(7, "w", [1, 2, 3], [0, 0, 0, 1]), "geometry_msgs/msg/PoseStamped")
    assert isinstance(back, ros.geometry_msgs__msg__PoseStamped)
    assert (back.pose.position.y, back.pose.orientation.w) == (2.0, 1.0)


def test_imu_without_orientation_says_so() -> None:
    back = decode(messages.imu(1, "i", None, [1, 2, 3], [4, 5, 6]), "sensor_msgs/msg/Imu")
    assert isinstance(back, ros.sensor_msgs__msg__Imu)
    assert back.orientation_covariance[0] == -1.0
    assert back.linear_acceleration.z == 6.0


def test_lengths_must_fit() -> None:
    with pytest.raises(ShapeError, match=r"position: expected shape \(2,\), got \(3,\)"):
        messages.joint_state(0, ("a", "b"), [1, 2, 3])
    with pytest.raises(ShapeError, match="force"):
        messages.wrench(0, "f", [1, 2], [1, 2, 3])
    with pytest.raises(ShapeError, match="position"):
        messages.joint_trajectory(0, ("a",), [0.0, 1.0], [[1.0]])


@pytest.mark.parametrize("stamp", [-1, 2**31 * 10**9])
def test_stamps_that_ros_cannot_hold_are_refused(stamp: int) -> None:
    with pytest.raises(ShoecalError, match="stamp"):
        messages.temperature(stamp, "", 20.0)


NAMES = ("left_knee", "r", "head")
stamps_of = st.lists(st.integers(0, 2**31 * 10**9 - 1), max_size=5).map(
    lambda found: np.array(found, dtype=np.int64)
)


def joints(stamp: int, numbers: FloatArray) -> bytes:
    return messages.joint_state(stamp, NAMES, numbers[:3], numbers[3:])


def inertial(stamp: int, numbers: FloatArray) -> bytes:
    return messages.imu(stamp, "base_link", numbers[:4], numbers[4:7], numbers[7:])


@pytest.mark.parametrize(("one", "count"), [(joints, 6), (inertial, 10)])
@given(data=st.data())
def test_a_series_is_what_single_messages_are(one, count: int, data: st.DataObject) -> None:  # type: ignore[no-untyped-def]
    stamps = data.draw(stamps_of)
    values = data.draw(hnp.arrays(np.float64, (len(stamps), count)))
    made = series(one, stamps, values)
    assert made == [one(int(at), row) for at, row in zip(stamps, values, strict=True)]


def test_wrong_calls_are_refused() -> None:
    one = np.array([1], dtype=np.int64)
    with pytest.raises(ShapeError, match="values"):
        series(joints, one, np.zeros((2, 6)))
    with pytest.raises(ShoecalError, match="must be 0 to 2"):
        series(joints, -one, np.zeros((1, 6)))
    with pytest.raises(ShoecalError, match="each number once"):
        series(lambda stamp, numbers: joints(stamp, 0.0 * numbers), one, np.zeros((1, 6)))
