"""What planned motions would tell stands on their page, with its unit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from core.report.pages import read
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.planning.supports.forecast import Addition, Forecast, WeakDirection
from shoecal_core.planning.supports.polygon_error import Expected, PolygonError
from shoecal_core.report.html import render
from shoecal_core.report.page import Page, Verdict
from shoecal_core.report.plan_forecast import (
    PlanForecast,
    forecast_figures,
    forecast_line,
    forecast_section,
)


def forecast(rank: int, foot_mm: float) -> Forecast:
    """Of two channels and three directions."""
    foot = Expected(1e-3 * foot_mm, 1.1e-3 * foot_mm)
    error = PolygonError(
        Expected(0.12, 0.2), Expected(1.8e-3, 2.2e-3), (Expected(0.3, 0.4), foot), (foot, foot)
    )
    weak = (WeakDirection("all offsets of one foot", math.inf), WeakDirection("gains", 1.78))
    return Forecast(
        np.array([0.03, 0.04]), np.array([0.5, 0.5]), np.array([0.01, 0.02, math.inf]), rank, 3,
        weak[: 3 - rank], error,
    )  # fmt: skip


@pytest.fixture
def poor() -> PlanForecast:
    better = Addition(DoubleSupport(0.08, -0.104, 0.468), forecast(3, 4.3))
    return PlanForecast((("all 2", forecast(1, 70.3)),), (better,))


def text_of(told: PlanForecast) -> str:
    page = Page(
        "plan", "", Verdict("PASS", "kept", (), lines=(forecast_line(told),)),
        forecast_figures(told), (forecast_section(told),), (),
    )  # fmt: skip
    return read(render(page)).text.replace("\N{NO-BREAK SPACE}", " ")


def test_too_little_is_told_before_anything_moves(poor: PlanForecast) -> None:
    text = text_of(poor)
    assert "from these motions alone would fix 1 of 3 directions" in text
    assert "the worse foot 70.3 mm" in text
    assert "3.5 %" in text
    assert "all offsets of one foot nothing is told of it" in text
    assert "gains 178 %" in text
    assert "x 80 mm, y −104 mm, yaw 26.8°" in text
    assert "1 → 3 of 3" in text
    assert "70.3 → 4.3 mm" in text


def test_enough_needs_no_advice() -> None:
    text = text_of(PlanForecast((("all 5", forecast(3, 4.0)),)))
    assert "would fix every direction that can be fixed" in text
    assert "Left open" not in text
    assert "What to add" not in text
