"""Verdicts by per cent of the weight and of half the width of a foot."""

from __future__ import annotations

import numpy as np
import pytest

from core.robot import robots
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.checks.accuracy import (
    COP_FAIL,
    COP_WARN,
    GRF_FAIL,
    GRF_WARN,
    Misfit,
    check_accuracy,
    check_promise,
    misfit,
    model_limit,
)
from shoecal_core.estimation.series import Errors, Mae, Series

ROBOT = robots.load("nao")
WIDTH = min(foot.half_width for foot in ROBOT.feet)
NONE = Mae(float("nan"), float("nan"), 0)


def mae(value: float) -> Mae:
    return Mae(value, 0.0, 100)


def errors(grf: float = 0.0, cop: float = 0.0, feet: tuple[Mae, Mae] = (NONE, NONE)) -> Errors:
    return Errors(mae(grf * ROBOT.weight), mae(cop * WIDTH), (NONE, NONE), feet)


@pytest.mark.parametrize(
    ("grf", "cop", "levels"),
    [
        (0.99 * GRF_WARN, 0.99 * COP_WARN, []),
        (1.01 * GRF_WARN, 0.0, ["WARN"]),
        (0.99 * GRF_FAIL, 1.01 * COP_WARN, ["WARN", "WARN"]),
        (1.01 * GRF_FAIL, 1.01 * COP_FAIL, ["FAIL", "FAIL"]),
        (np.nan, np.inf, ["FAIL", "FAIL"]),
    ],
)
def test_levels(grf: float, cop: float, levels: list[str]) -> None:
    found = check_accuracy("test", errors(grf, cop), ROBOT)
    assert [finding.verdict for finding in found] == levels
    assert all("off its model on test runs" in finding.reason for finding in found)


def test_one_foot_alone_can_fail() -> None:
    feet = (mae(0.1 * WIDTH), mae(1.01 * COP_FAIL * WIDTH))
    (finding,) = check_accuracy("train", errors(feet=feet), ROBOT)
    assert finding.verdict == "FAIL"
    assert f"right foot {1e3 * feet[1].mean:.2f} mm" in finding.reason


def series(force: FloatArray, place: FloatArray) -> Series:
    """Of both feet."""
    count = len(force)
    unknown = np.full((count, 2), np.nan)
    return Series(np.arange(count) / 50.0, force, place, unknown, np.full((count, 2, 2), np.nan))


def walked(together: float) -> list[tuple[Series, Series]]:
    """Measured and modelled of ten steps; the sensor follows the model by a share, else noise."""
    rng = np.random.default_rng(1)
    pairs = []
    for _ in range(10):
        force = ROBOT.weight * (1.0 + 0.05 * rng.standard_normal(60))
        model = 0.6 * WIDTH * rng.standard_normal((60, 2))
        own = 0.6 * WIDTH * rng.standard_normal((60, 2))
        shown = 0.4 * (together * model + (1.0 - together) * own)
        pairs.append((series(1.1 * force, shown), series(force, model)))
    return pairs


def test_a_sensor_that_follows_the_model_could_be_calibrated() -> None:
    limit = model_limit(walked(1.0))
    assert limit is not None
    assert limit.cop[0] < 1e-9
    assert limit.grf < 1e-9
    assert limit.together[0] == pytest.approx(1.0)
    found = check_accuracy("test", errors(0.1, 0.6), ROBOT, limit)
    assert [finding.verdict for finding in found] == ["FAIL", "FAIL"]


def test_where_they_do_not_move_together_the_model_is_the_limit() -> None:
    limit = model_limit(walked(0.0))
    assert limit is not None
    assert abs(limit.together[0]) < 0.1
    assert limit.cop[0] > 0.6 * WIDTH
    (finding,) = check_accuracy("test", errors(0.0, 0.8), ROBOT, limit)
    assert finding.verdict == "WARN"
    assert "the model of the walk, not the sensor, is the limit" in finding.reason


def test_a_robot_that_stands_has_no_such_limit() -> None:
    force, place = np.full(600, ROBOT.weight), np.zeros((600, 2))
    assert model_limit([(series(force, place), series(force, place))]) is None


def test_a_misfit_is_what_is_left_without_noise() -> None:
    """Whatever the noise of the readings: it says nothing of gains and offsets."""
    rng, time = np.random.default_rng(3), np.arange(2000) / 50.0
    slow = 0.004 * np.sin(0.7 * time)
    model = series(np.full(2000, 50.0), np.zeros((2000, 2)))
    for noise in (0.0, 0.003):
        place = slow[:, None] * [1.0, 0.0] + rng.normal(0.0, noise, (2000, 2))
        left = misfit([(series(50.0 + 1e3 * slow, place), model)])
        assert left.cop == pytest.approx(0.004 / np.sqrt(2.0), rel=0.05)
        assert left.grf == pytest.approx(4.0 / np.sqrt(2.0), rel=0.05)


def test_a_fit_that_contradicts_its_own_runs_fails() -> None:
    expected = Misfit(0.5, 0.0016)
    assert check_promise(Misfit(1.4, 0.0047), expected) == []
    (finding,) = check_promise(Misfit(1.4, 0.0063), expected)
    assert finding.verdict == "FAIL"
    assert "CoP 6.3 mm where 1.6 mm is expected" in finding.reason
    assert "GRF" not in finding.reason
    (finding,) = check_promise(Misfit(1.6, 0.0), expected)
    assert "GRF 1.6 N where 0.5 N is expected" in finding.reason
