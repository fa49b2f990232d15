from __future__ import annotations

import pytest

from ros.clock import Clock
from shoecal_ros.inputs.last_heard import LastHeard


@pytest.mark.parametrize(("period", "silent"), [(0.001, 0.08), (0.01, 0.08), (0.1, 0.27)])
def test_silence_is_told_within_a_tenth_of_a_second_or_three_periods(
    period: float, silent: float
) -> None:
    clock = Clock()
    heard = LastHeard(clock)
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
    heard = LastHeard(clock)
    for gap in (0.02, 0.02, 5.0, 0.02, 0.02):
        clock.now += gap
        heard.note()
    assert heard.patience_s == pytest.approx(0.08)


def test_rate_and_age_are_told() -> None:
    clock = Clock()
    heard = LastHeard(clock)
    assert heard.figures() == {"rate_hz": "0.0", "age_s": "never"}
    for _ in range(30):
        clock.now += 0.1
        heard.note(10)
        told = heard.figures()
    assert told == {"rate_hz": "100.0", "age_s": "0.000"}
    clock.now += 1.0
    assert heard.figures()["age_s"] == "1.000"
    assert float(heard.figures()["rate_hz"]) < 60.0
