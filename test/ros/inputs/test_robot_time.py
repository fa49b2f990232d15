from __future__ import annotations

import pytest

from ros.clock import Clock
from shoecal_ros.inputs.robot_time import FASTEST, RobotTime


def rate(pace: float, *, simulated: bool = True, burst: int = 1, count: int = 200) -> float:
    clock, time_ns = Clock(), 0
    robot_time = RobotTime(simulated=simulated, monotonic=clock)
    for _ in range(count):
        clock.now += 0.02 * burst
        time_ns += round(0.02e9 * burst * pace)
        robot_time.note(time_ns)
    return robot_time.rate


@pytest.mark.parametrize("burst", [1, 10])
def test_a_fast_simulation_is_measured(burst: int) -> None:
    assert rate(5.0, burst=burst) == pytest.approx(5.0)


def test_bounds() -> None:
    assert RobotTime(simulated=True).rate == 1.0
    assert rate(5.0, count=5) == 1.0, "too short to tell"
    assert rate(0.3) == 1.0
    assert rate(1e4) == FASTEST
    assert rate(5.0, simulated=False) == 1.0
