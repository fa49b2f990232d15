from __future__ import annotations

import pytest

from ros.clock import Clock
from shoecal_ros.common.awake_clock import CATCH_UP_S, LONGEST_S, AwakeClock


def test_it_goes_on_while_it_is_asked() -> None:
    clock = Clock()
    awake = AwakeClock(clock)
    for _ in range(50):
        clock.now += 0.1
        awake()
    assert awake() == pytest.approx(5.0)


def test_a_sleep_counts_for_a_moment_only() -> None:
    clock = Clock()
    awake = AwakeClock(clock)
    clock.now += 4.0
    assert awake() == pytest.approx(LONGEST_S)
    clock.now += 0.1
    assert awake() == pytest.approx(LONGEST_S + 0.1)


def test_after_a_sleep_it_catches_up_for_a_moment() -> None:
    clock = Clock()
    awake = AwakeClock(clock)
    assert not awake.catches_up()
    clock.now += 0.2
    assert not awake.catches_up()
    clock.now += 0.4
    assert awake.catches_up()
    for _ in range(3):
        assert awake.catches_up()
        clock.now += 0.35 * CATCH_UP_S
    assert not awake.catches_up()
