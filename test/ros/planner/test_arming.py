from __future__ import annotations

from ros.clock import Clock
from shoecal_ros.planner.arming import Arming


def test_nothing_is_armed_by_itself() -> None:
    arming = Arming(10.0, Clock())
    assert not arming.armed
    assert not arming.expire()


def test_it_ends_without_use() -> None:
    clock = Clock()
    arming = Arming(10.0, clock)
    arming.set(True)
    clock.now += 10.0
    assert not arming.expire()
    clock.now += 0.1
    assert arming.expire()
    assert not arming.armed
    assert not arming.expire(), "told once"
    assert arming.disarmings == 1


def test_use_keeps_it() -> None:
    clock = Clock()
    arming = Arming(10.0, clock)
    arming.set(True)
    for _ in range(5):
        clock.now += 9.0
        arming.use()
        assert not arming.expire()
    assert arming.armed


def test_disarming_wins_at_once() -> None:
    arming = Arming(10.0, Clock())
    arming.set(False)
    assert arming.disarmings == 0, "there was nothing to take back"
    arming.set(True)
    arming.set(False)
    assert not arming.armed
    arming.set(True)
    assert arming.disarmings == 1
