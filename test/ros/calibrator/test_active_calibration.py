from __future__ import annotations

import math

import pytest

from ros.bodies import calibration, nao, nao_shoe
from shoecal_ros.calibrator.active_calibration import ActiveCalibration
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Level
from shoecal_ros.common.origin import Origin

ORIGIN = Origin(simulated=False, host="lab", device="shoe_driver")
SINCE_NS = 1_700_000_000 * 10**9


def in_force(now: float = math.nan, **changes: object) -> ActiveCalibration:
    made = calibration(nao(), nao_shoe(), "made-1", **changes)
    return ActiveCalibration(made, ORIGIN, SINCE_NS, now)


def test_a_sentence_names_it_all() -> None:
    sentence = in_force(31.0, temperature=22.0).sentence
    for part in (
        "'made-1' (self, PASS)", "since 2023-11-14 22:13:20 UTC", "robot 'nao'",
        "shoe 'nao_shoe'", f"made {ORIGIN} at 22.0 degC", "now 31.0 degC",
    ):  # fmt: skip
        assert part in sentence
    assert "degC" not in in_force().sentence


def test_values_for_diagnostics() -> None:
    values = in_force(temperature=22.0).condition(5.0, delay_s=0.1).values
    assert values == {
        "id": "made-1",
        "source": "self",
        "verdict": "PASS",
        "in_force_since": "2023-11-14 22:13:20 UTC",
        "robot": "nao",
        "shoe": "nao_shoe",
        "made": "in wall-clock time on host 'lab' with device 'shoe_driver'",
        "temperature_then_degc": "22.0",
        "temperature_now_degc": "not known",
        "delay_s": "0.1",
    }


@pytest.mark.parametrize(
    ("then", "now", "level"),
    [
        (22.0, 26.9, Level.OK),
        (22.0, 31.0, Level.WARN),
        (31.0, 22.0, Level.WARN),
        (22.0, math.nan, Level.OK),
        (math.nan, 31.0, Level.OK),
    ],
)
def test_a_temperature_too_far_off_warns(then: float, now: float, level: Level) -> None:
    condition = in_force(now, temperature=then).condition(5.0)
    assert condition.level is level
    assert condition.code == (Code.OK if level is Level.OK else Code.TEMPERATURE_GAP)
    assert ("rezero" in condition.message) == (level is Level.WARN)
    if (then, now) == (22.0, 31.0):
        assert "calibrated at 22 degC, now 31: call shoe/rezero" in condition.message


def test_what_warned_goes_on_warning() -> None:
    condition = in_force(verdict="WARN", reasons=("odd", "strange")).condition(5.0)
    assert condition.level is Level.WARN
    assert condition.code == Code.CALIBRATION_WARNED
    assert condition.message == (
        "'made-1' in force (WARN): odd; strange; correct that and calibrate again"
    )


def test_a_level_is_told_once() -> None:
    warned = in_force(verdict="FAIL", reasons=("FAIL: odd", "WARN: strange"))
    condition = warned.condition(5.0)
    assert condition.message == (
        "'made-1' in force (FAIL): odd; WARN: strange; correct that and calibrate again"
    )
