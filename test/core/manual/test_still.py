from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from core.manual.benches import SETTINGS, nao_shoe
from shoecal_core.arrays import FloatArray
from shoecal_core.manual.loads import Load
from shoecal_core.manual.still import Last, StillReading, StillState

HOLE = Load(0, "a1", 2.0)
CELL = Load(0, "left/front_right", 2.0)
LIMIT = SETTINGS.still_fraction * 10.0
"""V; the converter's range is 10 V."""
STILL = np.array([0.1, 0.2, 0.3, 0.4])


def reading(load: Load = HOLE, last: Last | None = None) -> StillReading:
    return StillReading(nao_shoe(), load, SETTINGS, last)


def outcomes(one: StillReading, samples: Iterable[FloatArray]) -> list[StillState]:
    """What is said of each sample, up to the end of the reading."""
    found = []
    for sample in samples:
        found.append(one.take(sample))
        if found[-1] is not StillState.UNDER_WAY:
            break
    return found


def test_a_window_of_still_samples_is_a_reading() -> None:
    rng = np.random.default_rng(1)
    samples = STILL + rng.normal(0.0, 0.3 * LIMIT, (100, 4))
    one = reading()
    found = outcomes(one, samples)
    assert found == [StillState.UNDER_WAY] * 4 + [StillState.STILL]
    np.testing.assert_allclose(one.mean, samples[:5].mean(axis=0))
    np.testing.assert_allclose(one.std, samples[:5].std(axis=0, ddof=1))


@given(st.integers(0, 12), st.integers(0, 3))
def test_it_waits_until_it_is_still(restless: int, channel: int) -> None:
    swing = np.zeros((100, 4))
    swing[:restless, channel] = 5.0 * LIMIT * (-1.0) ** np.arange(restless)
    one = reading()
    found = outcomes(one, STILL + swing)
    assert found[-1] is StillState.STILL
    # Some of the last swings may stand in a window that counts as still already.
    assert restless <= len(found) <= restless + 5 or restless <= 1
    assert (one.std <= LIMIT).all()


def test_patience_ends() -> None:
    samples = [STILL + 10.0 * LIMIT * (index % 2) for index in range(100)]
    found = outcomes(reading(), samples)
    assert len(found) == SETTINGS.patience
    assert found[-1] is StillState.MOVED
    assert "again" in StillState.MOVED.value


def test_a_slow_drift_is_no_standing_still() -> None:
    samples = [STILL + index * 2.0 * LIMIT for index in range(100)]
    assert outcomes(reading(), samples)[-1] is StillState.MOVED


def test_a_cell_that_gives_nothing() -> None:
    gap = STILL.copy()
    gap[2] = np.nan
    assert outcomes(reading(), [gap] * 100)[-1] is StillState.SILENT
    # One gap begins the reading anew.
    assert len(outcomes(reading(), [STILL] * 3 + [gap] + [STILL] * 10)) == 9


def test_only_the_loaded_cell_counts_where_it_is_alone() -> None:
    beside = np.array([np.nan, 0.2, np.nan, 0.4])
    shake = np.array([0.0, 0.0, 0.0, 1.0])
    restless = [beside + index % 2 * shake for index in range(100)]
    one = reading(CELL)
    assert outcomes(one, restless)[-1] is StillState.STILL
    np.testing.assert_array_equal(np.isnan(one.mean), np.isnan(beside))


def test_a_weight_that_was_not_moved() -> None:
    last = Last(Load(0, "a2", 2.0), STILL)
    assert outcomes(reading(last=last), [STILL] * 100)[-1] is StillState.UNCHANGED
    moved = STILL + np.array([0.0, 0.0, 0.0, 10.0 * LIMIT])
    assert outcomes(reading(last=last), [moved] * 100)[-1] is StillState.STILL
    # It is waited for: the weight may be on its way.
    assert len(outcomes(reading(last=last), [STILL] * 7 + [moved] * 100)) == 12


@pytest.mark.parametrize(
    ("load", "before"),
    [
        (HOLE, HOLE),  # once more the same
        (HOLE, Load(1, "a1", 2.0)),  # the other shoe
        (CELL, Load(0, "left/front_left", 2.0)),  # another cell
        (CELL, HOLE),
    ],
)
def test_where_nothing_has_to_change(load: Load, before: Load) -> None:
    assert outcomes(reading(load, Last(before, STILL)), [STILL] * 10)[-1] is StillState.STILL
