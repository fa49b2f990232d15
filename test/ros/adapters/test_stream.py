"""Set points of trajectories."""

from __future__ import annotations

import numpy as np
import pytest

from ros.bodies import nao
from shoecal_core.errors import ShoecalError
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_ros.adapters.foreign import PackageMissingError, foreign
from shoecal_ros.adapters.lola import NUMBERS, numbered
from shoecal_ros.adapters.stream import REPEATED_S, Stream

KNEE = "LKneePitch"


def bend(times: list[float], ways: list[float]) -> JointTrajectory:
    start = nao().posture[nao().joint(KNEE)]
    return JointTrajectory((KNEE,), np.array(times), start + np.array(ways)[:, None])


def test_it_is_silent_before_and_after() -> None:
    stream = Stream(nao())
    assert stream.at(5.0) is None
    stream.begin(bend([0.0, 2.0], [0.0, 0.2]), nao().posture, 10.0)
    assert stream.active
    last = stream.at(12.0 + REPEATED_S)
    assert last is not None
    assert last[0] - nao().posture[nao().joint(KNEE)] == pytest.approx(0.2)
    assert stream.at(12.1 + REPEATED_S) is None
    assert not stream.active


def test_a_first_point_that_comes_later_is_moved_to() -> None:
    """From where the joints were last told to be, be that a little off what is measured."""
    stream, start = Stream(nao()), nao().posture[nao().joint(KNEE)]
    stream.begin(bend([0.0, 2.0], [0.0, 0.2]), nao().posture, 0.0)
    stream.begin(bend([1.0], [0.0]), nao().posture, 2.0)
    first, middle, end = (stream.at(time_s) for time_s in (2.0, 2.5, 3.0))
    assert first is not None
    assert middle is not None
    assert end is not None
    assert first[0] - start == pytest.approx(0.2)
    assert 0.05 < middle[0] - start < 0.15
    assert end[0] - start == pytest.approx(0.0)


def test_it_stops_where_it_is() -> None:
    stream = Stream(nao())
    stream.begin(bend([0.0, 2.0], [0.0, 0.2]), nao().posture, 0.0)
    here = stream.at(1.0)
    assert stream.under_way(1.0)
    stream.stop(1.0)
    assert not stream.under_way(1.0)
    for time_s in (1.0, 1.5):
        assert stream.at(time_s) == pytest.approx(here)
    assert stream.at(1.1 + REPEATED_S) is None


def test_limits_hold() -> None:
    with pytest.raises(ShoecalError, match="beyond its limits"):
        Stream(nao()).begin(bend([0.0, 1.0], [0.0, 9.0]), nao().posture, 0.0)


def test_numbers_of_lola() -> None:
    """Both hips are one motor, which has the left one's number."""
    assert len(NUMBERS) == 25
    assert set(nao().joint_names) - set(NUMBERS) == {"RHipYawPitch"}
    assert numbered(["RHipYawPitch", "RHand", "HeadYaw"], [0.1, 0.2, 0.3]) == ([24, 0], [0.2, 0.3])


def test_a_package_that_is_not_installed_is_told() -> None:
    with pytest.raises(PackageMissingError) as error:
        foreign("no_such_msgs", "msg", "Nothing")
    assert "sudo apt install ros-jazzy-no-such-msgs" in str(error.value)
