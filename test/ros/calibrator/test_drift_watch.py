from __future__ import annotations

import math

import numpy as np
import pytest

from ros.instants import batch, joined
from shoecal_core.estimation.checks.drift import Drift
from shoecal_ros.calibrator.drift_watch import CONFIRM, LEAST_READINGS, DriftWatch
from shoecal_ros.common.health import Health, Level


def drift(grf: float, hanging: float = math.nan) -> Drift:
    return Drift(
        grf_error=grf,
        cop_error=0.002,
        hanging_error=hanging,
        grf_limit=0.9,
        cop_limit=0.008,
        hanging_limit=math.nan if math.isnan(hanging) else 0.5,
        hanging="" if math.isnan(hanging) else "left",
        covered=True,
    )


def test_drift_is_told_when_it_is_confirmed_and_taken_back_likewise() -> None:
    watch = DriftWatch(5.0)
    assert "stand still for 5 s" in watch.condition.message
    reported = []
    for grf in (0.1, 2.0, 0.1, 2.0, 2.1, 0.1, 2.2, 0.2, 0.1, 2.0):
        watch.judge(drift(grf))
        reported.append(watch.drifted)
    assert reported == [False] * 4 + [True] * 4 + [False] * 2


def test_what_is_told_belongs_to_what_is_shown() -> None:
    watch = DriftWatch(5.0)
    watch.judge(drift(2.0))
    assert watch.condition.level is Level.OK
    assert "not compared yet" in watch.condition.message
    watch.judge(drift(2.5))
    watch.judge(drift(-0.1))
    condition = watch.condition
    assert condition.level is Level.WARN
    assert "GRF is +2.50 N off the weight (expected within 0.90 N)" in condition.message
    assert "shoe/rezero" in condition.message
    assert condition.values["grf_error_n"] == "-0.100"


def test_a_foot_in_the_air_is_shown() -> None:
    watch = DriftWatch(5.0)
    for _ in range(CONFIRM):
        watch.judge(drift(0.0, hanging=0.7))
    assert watch.drifted
    values = watch.condition.values
    assert (values["hanging_foot"], values["hanging_error_n"]) == ("left", "0.700")


def test_another_calibration_begins_anew() -> None:
    watch = DriftWatch(5.0)
    for _ in range(CONFIRM):
        watch.judge(drift(2.0))
    watch.begin()
    assert not watch.drifted
    assert watch.found is None
    watch.judge(drift(2.0))
    assert not watch.drifted


def test_standstills_are_collected_and_interrupted() -> None:
    watch = DriftWatch(2.0)
    whole = [watch.look(joined(step), batch()) for step in range(50)]
    assert [step for step, one in enumerate(whole) if one] == [20, 41]
    first = whole[20]
    assert first is not None
    np.testing.assert_allclose(first.readings, 1.0)
    watch.interrupt()
    assert not any(watch.look(joined(step), batch()) for step in range(60, 80))
    assert watch.look(joined(80), batch())


def test_a_cell_that_gives_nothing_interrupts() -> None:
    watch = DriftWatch(2.0)
    for step in range(20):
        watch.look(joined(step), batch())
    assert watch.look(joined(20, bad=1), batch()) is None
    assert watch.look(joined(21), batch()) is None


@pytest.mark.parametrize("least", [LEAST_READINGS])
def test_a_few_readings_are_no_standstill(least: int) -> None:
    watch = DriftWatch(0.5)
    whole = [watch.look(joined(9 * step), batch()) for step in range(least)]
    assert [bool(one) for one in whole] == [False] * (least - 1) + [True]


def test_other_signs_are_no_news() -> None:
    health = Health()
    for grf in (0.1, -0.1):
        watch = DriftWatch(5.0)
        watch.judge(drift(grf))
        health.note("drift", watch.condition)
    assert list(health.news()) == ["drift"]
    health.note("drift", watch.condition)
    assert health.news() == {}
