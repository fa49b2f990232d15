from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.errors import NameNotFoundError, ShoecalError
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.planning.standard import (
    STANDARD,
    STANDARD_SUPPORTS,
    UNLOADING,
    PlannedRun,
    listed_runs,
    standard_runs,
)
from shoecal_core.robot.double_support import DoubleSupport

yaws = st.lists(st.floats(-0.4, 0.4), min_size=1, max_size=9, unique=True)


def at(yaw: float) -> DoubleSupport:
    return DoubleSupport(0.01 * yaw, -0.12, yaw)


NEUTRAL = DoubleSupport(0.0, -0.1, 0.0)


def drawn(supports: list[DoubleSupport]) -> list[PlannedRun]:
    """The standard set without what is done in the neutral support."""
    runs = standard_runs(supports, NEUTRAL)
    return [run for run in runs if run.motion not in UNLOADING]


def test_the_set_is_what_a_diagnosis_asks_for() -> None:
    wanted = Counter({"train": 5, "test": 2})
    assert Counter(one.hint for one in STANDARD) == wanted
    assert {one.motion for one in STANDARD} <= set(MOTION_KINDS)
    assert {one.motion for one in STANDARD if one.hint == "test"} == {"landmarks", "reversed"}


@given(yaws)
def test_every_motion_is_done_once_and_every_support_is_visited(found: list[float]) -> None:
    supports = [at(yaw) for yaw in found]
    runs = standard_runs(supports, NEUTRAL)
    assert [(run.motion, run.hint) for run in runs] == [(one.motion, one.hint) for one in STANDARD]
    unloading = {run.support for run in runs if run.motion in UNLOADING}
    assert unloading == {NEUTRAL}
    runs = tuple(run for run in runs if run.motion not in UNLOADING)
    assert {run.support for run in runs} <= set(supports)
    if len(supports) <= STANDARD_SUPPORTS:
        assert {run.support for run in runs} == set(supports)


@given(yaws.filter(lambda found: len(found) > 3))
def test_tests_stand_where_nothing_was_trained_within_the_trained_yaws(found: list[float]) -> None:
    runs = drawn([at(yaw) for yaw in found])
    trained, tested = (
        {run.support for run in runs if run.hint == hint} for hint in ("train", "test")
    )
    assert not trained & tested
    assert len(trained) >= 3
    assert len(tested) == min(2, len(found) - 3)
    if len(found) <= STANDARD_SUPPORTS:
        lowest, highest = np.sort([support.dtheta for support in trained])[[0, -1]]
        assert all(lowest < support.dtheta < highest for support in tested)


def test_with_few_supports_no_motion_is_tested_where_it_was_trained() -> None:
    for count in (2, 3):
        runs = drawn([at(0.1 * index) for index in range(count)])
        done = {(run.motion, run.support) for run in runs}
        assert len(done) == len(runs)


def test_listed_motions_visit_the_supports_in_turn() -> None:
    one, other = at(0.0), at(0.2)
    runs = listed_runs([one, other], ["landmarks", "hold", "faster"])
    assert [(run.support, run.motion, run.hint) for run in runs] == [
        (one, "landmarks", ""),
        (other, "hold", ""),
        (one, "faster", ""),
    ]


def test_wrong_lists_are_refused() -> None:
    with pytest.raises(NameNotFoundError, match="no motion named 'dance'"):
        listed_runs([at(0.0)], ["dance"])
    with pytest.raises(ShoecalError, match="name at least one"):
        listed_runs([at(0.0)], [])
    with pytest.raises(ShoecalError, match="give at least one"):
        listed_runs([], ["hold"])
    with pytest.raises(ShoecalError, match="give at least one"):
        standard_runs([], NEUTRAL)
