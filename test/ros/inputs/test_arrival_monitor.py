from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros.clock import Clock
from shoecal_ros.inputs.arrival_monitor import LOOK_S, ArrivalMonitor


@pytest.mark.parametrize(("period", "silent"), [(0.001, 0.08), (0.01, 0.08), (0.1, 0.26)])
def test_silence_is_told_within_a_tenth_of_a_second_or_three_periods(
    period: float, silent: float
) -> None:
    clock = Clock()
    heard = ArrivalMonitor(clock)
    assert heard.silent
    for _ in range(20):
        clock.now += period
        heard.note()
    assert heard.patience_s == pytest.approx(silent)
    clock.now += 0.99 * silent
    assert not heard.silent
    clock.now += 0.02 * silent
    assert heard.silent


def test_one_gap_makes_nobody_patient() -> None:
    clock = Clock()
    heard = ArrivalMonitor(clock)
    for gap in (0.02, 0.02, 5.0, 0.02, 0.02):
        clock.now += gap
        heard.note()
    assert heard.patience_s == pytest.approx(0.08)


def test_rate_and_age_are_told() -> None:
    clock = Clock()
    heard = ArrivalMonitor(clock)
    assert heard.figures() == {"rate_hz": "0.0", "age_s": "never"}
    for _ in range(30):
        clock.now += 0.1
        heard.note(10)
        reported = heard.figures()
    assert reported == {"rate_hz": "100.0", "age_s": "0.000"}
    clock.now += 1.0
    assert heard.figures()["age_s"] == "1.000"
    assert float(heard.figures()["rate_hz"]) < 60.0


PERIODS = st.lists(st.sampled_from([0.001, 0.005, 0.033, 0.05, 0.1]), min_size=1, max_size=40)


@given(periods=PERIODS)
def test_who_looks_when_told_to_misses_no_silence_when_the_period_changes(
    periods: list[float],
) -> None:
    """What comes every 0.1 s is waited for longer; once it comes every 5 ms, no longer."""
    clock = Clock()
    heard = ArrivalMonitor(clock)
    look = clock.now + heard.next_look_s
    for period in periods:
        news = clock.now + period
        while look < news:
            clock.now = look
            look += heard.next_look_s + 1e-9
        clock.now = news
        heard.note()
    last = clock.now
    while not heard.silent:
        clock.now = look
        look += heard.next_look_s + 1e-9
    assert clock.now - last <= heard.patience_s + LOOK_S
