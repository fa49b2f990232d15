from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.errors import ShoecalError
from shoecal_ros.calibrator.load import LEFT, RIGHT, LoadSwitch

FORCES = st.lists(st.tuples(st.floats(-5.0, 60.0), st.floats(-5.0, 60.0)), max_size=30)


def test_no_flutter_between_the_limits() -> None:
    switch = LoadSwitch(6.0, 3.0)
    assert switch.update(4.0, 50.0) == (False, True)
    assert switch.update(6.1, 50.0) == (True, True)
    assert switch.update(3.1, 50.0) == (True, True)
    assert switch.update(2.9, 50.0) == (False, True)
    assert switch.update(5.9, 50.0) == (False, True)


def test_the_frame_is_the_left_one_while_it_carries_load() -> None:
    switch = LoadSwitch(6.0, 3.0)
    assert switch.frame == LEFT
    switch.update(0.0, 50.0)
    assert switch.frame == RIGHT
    switch.update(10.0, 40.0)
    assert switch.frame == LEFT
    switch.update(50.0, 0.0)
    assert switch.frame == LEFT
    switch.update(0.0, 0.0)
    assert switch.frame == LEFT


def test_what_is_not_known_changes_nothing() -> None:
    switch = LoadSwitch(6.0, 3.0)
    switch.update(20.0, 30.0)
    assert switch.update(math.nan, 30.0) == (True, True)
    assert switch.frame == LEFT


@given(FORCES)
def test_a_loaded_foot_always_has_a_cop(forces: list[tuple[float, float]]) -> None:
    switch = LoadSwitch(6.0, 3.0)
    for left, right in forces:
        for force, loaded in zip((left, right), switch.update(left, right), strict=True):
            assert not loaded or force > 3.0
            assert loaded or force <= 6.0


@pytest.mark.parametrize(("on", "off"), [(3.0, 6.0), (3.0, 0.0)])
def test_limits_that_make_no_sense(on: float, off: float) -> None:
    with pytest.raises(ShoecalError, match="load_on_n"):
        LoadSwitch(on, off)
