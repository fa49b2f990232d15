"""Runs that were recorded under other gains than the rest."""

from __future__ import annotations

import re

import numpy as np
import pytest

from core.screening.loads.test_weights import carrying
from core.screening.recordings import Recording, read_coarsely, recording
from core.screening.test_screen import screened
from shoecal_core.arrays import FloatArray
from shoecal_core.screening.cells.changed_gains import (
    ChangedGains,
    changed_gains,
    describe_changed_gains,
)
from shoecal_core.screening.faults import Fault


def found(whole: Recording) -> ChangedGains | None:
    return changed_gains(whole.statics)


def reading(whole: Recording, runs: tuple[int, ...], times: FloatArray) -> Recording:
    """Some runs read so many times as much, by channel (n,)."""
    return whole.with_readings(lambda run, values: values * times if run in runs else values)


def words(whole: Recording) -> str:
    changed = found(whole)
    assert changed is not None
    (finding,) = describe_changed_gains(whole.shoe, changed)
    assert finding.verdict == "FAIL"
    return finding.reason


@pytest.mark.parametrize("seed", range(1, 7))
def test_gains_that_stay(seed: int) -> None:
    assert found(recording(seed, count=5)) is None
    assert found(read_coarsely(recording(seed, count=5), 10, 0.01)) is None


@pytest.mark.parametrize("times", [0.5, 4.0])
@pytest.mark.parametrize(("runs", "named"), [((4, 5), "runs 4 and 5"), ((2,), "run 2")])
def test_another_range_of_one_foots_amplifier(
    runs: tuple[int, ...], named: str, times: float
) -> None:
    whole = recording(count=5)
    left = np.where(whole.shoe.foot == 0, times, 1.0)
    text = words(reading(whole, runs, left))
    shown = re.fullmatch(
        r"all readings of the left foot are (\S+) times as large in (.*) as .*", text
    )
    assert shown is not None
    assert float(shown[1]) == pytest.approx(times, rel=0.05)
    assert shown[2] == named


def test_one_cell_that_was_exchanged() -> None:
    whole, times = recording(count=5), np.ones(8)
    times[5] = 1.4
    changed = found(reading(whole, (4, 5), times))
    assert changed is not None
    assert changed.runs == (4, 5)
    assert changed.ratio == {5: pytest.approx(1.0 / 1.4, rel=0.05)}


def test_other_shoes() -> None:
    whole = recording(count=5)
    times = np.exp(np.random.default_rng(3).normal(0.0, 0.4, 8))
    other = reading(whole, (3, 4), times)
    other = other.with_readings(lambda run, values: values + 0.2 * (run in (3, 4)))
    assert "the cells answer otherwise in runs 3 and 4 than in the others" in words(other)
    fault = [finding.fault for finding in screened(other).findings]
    assert fault == [Fault.CHANGED_GAINS]


def test_another_weight_is_no_gain() -> None:
    assert found(carrying(recording(count=5), 2, 12.0)) is None
    assert found(reading(recording(count=5), (2, 3), np.full(8, 1.2))) is None


def test_another_sign_is_no_gain() -> None:
    """Gains of their own also take up runs in which a foot hung: no amplifier does that."""
    times = np.ones(8)
    times[2] = -1.0
    assert found(reading(recording(count=5), (4, 5), times)) is None


def test_a_tare_is_no_gain() -> None:
    whole = recording(count=5).with_readings(
        lambda run, values: values - values[0] if run > 2 else values
    )
    assert found(whole) is None


def test_of_two_runs_none_is_the_odd_one() -> None:
    whole = recording(count=2)
    assert found(reading(whole, (2,), np.where(whole.shoe.foot == 0, 0.5, 1.0))) is None
