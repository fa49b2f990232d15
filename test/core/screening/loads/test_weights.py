"""A run under another weight than the others."""

from __future__ import annotations

import pytest

from core.screening.recordings import Recording, recording
from shoecal_core.screening.loads.weights import WrongWeight, wrong_weights


def found(whole: Recording) -> list[WrongWeight]:
    return wrong_weights(whole.statics)


def carrying(whole: Recording, run: int, newtons: float) -> Recording:
    """The load is spread evenly over all cells."""
    share = newtons / len(whole.shoe.names) / whole.parameters.gain
    return whole.with_readings(lambda number, values: values + (share if number == run else 0.0))


@pytest.mark.parametrize("count", [2, 3, 5])
def test_runs_that_agree(count: int) -> None:
    assert found(recording(count=count)) == []


@pytest.mark.parametrize("newtons", [-8.0, -1.8, 1.8, 5.0])
@pytest.mark.parametrize("run", [1, 3])
def test_the_one_that_does_not(run: int, newtons: float) -> None:
    (one,) = found(carrying(recording(run, count=5), run, newtons))
    assert one.run == run
    assert one.excess == pytest.approx(newtons, abs=0.3)
    assert not one.undecided


def test_the_worst_of_two_is_told_first() -> None:
    whole = carrying(carrying(recording(count=5), 2, 3.0), 4, -6.0)
    assert [one.run for one in found(whole)] == [4, 2]


def test_of_two_runs_nothing_tells_which_is_right() -> None:
    one, other = found(carrying(recording(count=2), 1, 6.0))
    assert one.undecided
    assert other.undecided
    assert {one.run, other.run} == {1, 2}


def test_what_is_within_the_models_error_is_none() -> None:
    assert found(carrying(recording(count=5), 2, 0.5)) == []


def test_all_alike_look_like_other_gains() -> None:
    whole = recording(count=5)
    for run in whole.aligned:
        whole = carrying(whole, run, 5.0)
    assert found(whole) == []
