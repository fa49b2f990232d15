from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.errors import NameNotFoundError, ShoecalError
from shoecal_core.planning.motion_catalogue import MOTION_KINDS
from shoecal_core.planning.motion_sets import (
    MOTION_SETS,
    STANDARD,
    STANDARD_SUPPORTS,
    UNLOADING,
    PlannedRun,
    listed_runs,
    set_runs,
)
from shoecal_core.robot.double_support import DoubleSupport

yaws = st.lists(st.floats(-0.4, 0.4), min_size=1, max_size=9, unique=True)


def at(yaw: float) -> DoubleSupport:
    return DoubleSupport(0.01 * yaw, -0.12, yaw)


NEUTRAL = DoubleSupport(0.0, -0.1, 0.0)


def drawn(name: str, supports: list[DoubleSupport]) -> list[PlannedRun]:
    """A set without what is done in the neutral support."""
    runs = set_runs(name, supports, NEUTRAL)
    return [run for run in runs if run.motion not in UNLOADING]


@pytest.mark.parametrize("name", MOTION_SETS)
def test_sets_are_of_the_catalogue_and_test_what_they_do_not_train(name: str) -> None:
    one = MOTION_SETS[name]
    assert {*one.train, *one.test} <= set(MOTION_KINDS)
    assert set(one.train) >= set(UNLOADING)
    assert one.test
    assert len(one.runs) == len(one)


@pytest.mark.parametrize("name", MOTION_SETS)
@given(found=yaws)
def test_every_motion_is_done_once_and_every_support_is_visited(
    name: str, found: list[float]
) -> None:
    supports = [at(yaw) for yaw in found]
    runs = set_runs(name, supports, NEUTRAL)
    assert tuple((run.motion, run.hint) for run in runs) == MOTION_SETS[name].runs
    assert {run.support for run in runs if run.motion in UNLOADING} == {NEUTRAL}
    elsewhere = {run.support for run in drawn(name, supports)}
    assert elsewhere <= set(supports)
    if len(supports) <= STANDARD_SUPPORTS:
        assert elsewhere == set(supports)


@pytest.mark.parametrize("name", MOTION_SETS)
@given(found=yaws.filter(lambda found: len(found) > 3))
def test_tests_stand_where_nothing_was_trained_within_the_trained_yaws(
    name: str, found: list[float]
) -> None:
    runs = drawn(name, [at(yaw) for yaw in found])
    trained, tested = (
        {run.support for run in runs if run.hint == hint} for hint in ("train", "test")
    )
    assert not trained & tested
    moving = len(set(MOTION_SETS[name].train) - set(UNLOADING))
    assert len(trained) == moving
    assert len(tested) == min(len(MOTION_SETS[name].test), len(found) - moving)
    if len(found) <= STANDARD_SUPPORTS:
        lowest, highest = np.sort([support.dtheta for support in trained])[[0, -1]]
        assert all(lowest < support.dtheta < highest for support in tested)


@pytest.mark.parametrize("name", MOTION_SETS)
@pytest.mark.parametrize("count", [2, 3])
def test_with_few_supports_no_motion_is_tested_where_it_was_trained(name: str, count: int) -> None:
    runs = drawn(name, [at(0.1 * index) for index in range(count)])
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
        set_runs(STANDARD, [], NEUTRAL)
