from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from core.simulation.effects.chains import NAO, PERIOD, item, shoes_with, through

RAMP = np.tile(10.0 * np.arange(0.0, 3.0, PERIOD)[:, None], 8)
"""N; 10 N/s."""


@settings(max_examples=25)
@given(st.floats(0.002, 0.2))
def test_a_ramp_is_behind_by_the_time_of_a_low_pass(time: float) -> None:
    reached = through(shoes_with(item("low_pass", "right", time_s=time)), RAMP)
    assert (RAMP - reached)[-1, 4:] == pytest.approx(np.full(4, 10.0 * time), rel=1e-2)
    assert (reached[:, :4] == RAMP[:, :4]).all()


def test_a_step_begins_softly_as_behind_two_lags() -> None:
    step = np.vstack((np.zeros((1, 8)), np.ones((300, 8))))
    reached = through(shoes_with(item("low_pass", "all", time_s=0.2)), step, period=0.001)[1:, 0]
    ratio = np.arange(300) * 0.001 / 0.1
    assert reached == pytest.approx(1.0 - (1.0 + ratio) * np.exp(-ratio), abs=6e-3)


@settings(max_examples=25)
@given(st.floats(0.0, 0.5))
def test_late_readings_are_those_of_before(delay: float) -> None:
    reached = through(shoes_with(item("latency", "left", delay_s=delay)), RAMP)
    expected = np.maximum(RAMP[:, :4] - 10.0 * delay, 0.0)
    assert reached[:, :4] == pytest.approx(expected, abs=1e-9)
    assert (reached[:, 4:] == RAMP[:, 4:]).all()


def test_a_late_reading_was_filtered_before() -> None:
    effects = item("latency", "all", delay_s=0.1), item("low_pass", "all", time_s=0.1)
    reached = through(shoes_with(*effects), RAMP)
    assert (RAMP - reached)[-1] == pytest.approx(np.full(len(NAO.channels), 2.0), rel=1e-2)
