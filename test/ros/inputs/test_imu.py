from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import Imu

from ros.bodies import nao
from shoecal_core.arrays import FloatArray
from shoecal_ros.common.conversions import header_to_ros
from shoecal_ros.inputs.imu import ImuInput

UP = np.array([0.0, 0.0, 1.0])


def reported(stamp_ns: int, turn: Rotation, *, orientation: bool = True, g: float = 9.81) -> Imu:
    """What a sensor says on a torso that is turned so."""
    message = Imu(header=header_to_ros(stamp_ns, "base_link"))
    if orientation:
        q = message.orientation
        q.x, q.y, q.z, q.w = turn.as_quat().tolist()
    else:
        message.orientation_covariance[0] = -1.0
    felt = message.linear_acceleration
    felt.x, felt.y, felt.z = (g * turn.inv().apply(UP)).tolist()
    return message


LEANING = Rotation.from_euler("zyx", [2.0, 0.2, -0.1])


def seen(turn: Rotation) -> FloatArray:
    up: FloatArray = turn.inv().apply(UP)
    return up


def test_nothing_heard() -> None:
    imu = ImuInput(nao())
    assert imu.up is None
    assert imu.heard.age_s == np.inf


@pytest.mark.parametrize("orientation", [True, False])
def test_up_whatever_the_heading(orientation: bool) -> None:
    imu = ImuInput(nao())
    imu.take([reported(10**9, LEANING, orientation=orientation)])
    assert imu.up == pytest.approx(seen(LEANING))
    assert imu.heard.age_s < 1.0


def test_an_accelerometer_that_shakes_is_smoothed() -> None:
    imu, rng = ImuInput(nao()), np.random.default_rng(1)
    shaken = [
        reported(10**9 + index * 10_000_000, Rotation.from_rotvec(0.05 * rng.standard_normal(3)),
             orientation=False)
        for index in range(200)
    ]  # fmt: skip
    imu.take(shaken)
    assert imu.up is not None
    assert np.arccos(imu.up[2]) < 0.03


def test_a_sensor_that_tells_no_direction_is_not_heard() -> None:
    imu = ImuInput(nao())
    silent = Imu()
    silent.orientation_covariance[0] = -1.0
    imu.take([silent, reported(10**9, LEANING, orientation=False, g=0.1)])
    assert imu.up is None
    assert imu.heard.age_s == np.inf


def test_a_clock_that_was_set_back_begins_anew() -> None:
    imu = ImuInput(nao())
    imu.take([reported(10**12, Rotation.identity(), orientation=False)])
    imu.take([reported(10**9, LEANING, orientation=False)])
    assert imu.up == pytest.approx(seen(LEANING))
