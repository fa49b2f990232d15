"""The permutation test on runs: its size where nothing differs, its power, its interval."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from shoecal_core.calibration import significance
from shoecal_core.calibration.significance import Difference, Stratum, compare_sets
from shoecal_core.errors import ShoecalError


def difference(strata: Sequence[Stratum], seed: int = 1) -> Difference:
    found = compare_sets(strata, np.random.default_rng(seed))
    assert found is not None
    return found


def drawn(
    rng: np.random.Generator,
    sizes: Sequence[tuple[int, int]],
    shift: float = 0.0,
) -> list[Stratum]:
    """Sessions that differ far more from each other than their runs do."""
    return [
        (level + rng.gamma(4.0, 0.1, one), level + rng.gamma(4.0, 0.1, other) + shift)
        for (one, other) in sizes
        for level in [rng.uniform(1.0, 9.0)]
    ]


def moved(strata: Sequence[Stratum], shift: float) -> list[Stratum]:
    return [(one, other + shift) for one, other in strata]


SIZES = st.lists(st.tuples(st.integers(1, 4), st.integers(1, 3)), min_size=1, max_size=3)


def test_five_runs_can_never_be_significant() -> None:
    """Ten splits of 3 and 2, so 0.1 at the least, and no shift can be refused at 5 %."""
    found = difference([(np.array([1.0, 1.1, 1.2]), np.array([8.0, 9.0]))])
    assert found.exact
    assert found.splits == 10
    assert found.p_value == found.smallest_p == pytest.approx(0.1)
    assert not found.significant
    assert found.interval == (-math.inf, math.inf)
    assert found.value == pytest.approx(7.4)


def test_two_sessions_can() -> None:
    found = difference(2 * [(np.array([1.0, 1.1, 1.2]), np.array([8.0, 9.0]))])
    assert found.splits == 100
    assert found.p_value == pytest.approx(0.01)
    assert found.significant
    assert 0.0 < found.interval[0] < 7.4 < found.interval[1] < math.inf
    assert (found.sessions, found.first, found.second) == (2, 6, 4)


def test_one_session_by_hand() -> None:
    """Runs 1, 2 | 4: splits have second-set means 4, 2, 1, so differences 2.5, -0.5, -2."""
    found = difference([(np.array([1.0, 2.0]), np.array([4.0]))])
    assert found.value == pytest.approx(2.5)
    assert found.p_value == pytest.approx(1.0 / 3.0)
    found = difference([(np.array([1.0, 4.0]), np.array([2.0]))])
    assert found.value == pytest.approx(-0.5)
    assert found.p_value == 1.0


def test_equal_sizes_have_a_mirror() -> None:
    found = difference([(np.array([1.0, 2.0, 3.0]), np.array([7.0, 8.0, 9.0]))])
    assert found.p_value == found.smallest_p == pytest.approx(2.0 / 20.0)


@pytest.mark.parametrize("sizes", [[(3, 2)] * 2, [(3, 2), (4, 1), (2, 3)], [(4, 4)]])
def test_nothing_differs_so_nothing_is_found(sizes: list[tuple[int, int]]) -> None:
    """p is uniform on its steps under the null: no more than 5 % fall below 5 %."""
    rng = np.random.default_rng(11)
    found = [difference(drawn(rng, sizes)) for _ in range(1500)]
    p_values = np.array([one.p_value for one in found])
    for level in (0.05, 0.1, 0.3, 0.7):
        # A test of discrete p values holds its level and lies a step below it at most.
        below = int(np.sum(p_values <= level * (1.0 + 1e-9)))
        assert stats.binomtest(below, len(found), level, alternative="greater").pvalue > 1e-3
        lower = level - 2.0 * found[0].smallest_p
        if lower > 0.0:
            assert stats.binomtest(below, len(found), lower, alternative="less").pvalue > 1e-3
    covered = sum(one.interval[0] <= 0.0 <= one.interval[1] for one in found)
    assert covered == sum(not one.significant for one in found)


def test_a_difference_is_found() -> None:
    """Ten sessions of 3 and 2 find a shift of one standard deviation in four of five cases."""
    rng = np.random.default_rng(12)
    sigma = 0.1 * math.sqrt(4.0)
    found = [difference(drawn(rng, [(3, 2)] * 10, shift=sigma)) for _ in range(40)]
    assert np.mean([one.significant for one in found]) > 0.65
    assert np.mean([one.value for one in found]) == pytest.approx(sigma, rel=0.2)
    covered = [one.interval[0] <= sigma <= one.interval[1] for one in found]
    assert np.mean(covered) >= 0.85


def test_what_distinguishes_sessions_plays_no_part() -> None:
    rng = np.random.default_rng(13)
    strata = drawn(rng, [(3, 2)] * 3)
    shifted = [(one + 50.0 * i, other + 50.0 * i) for i, (one, other) in enumerate(strata)]
    one, other = difference(strata), difference(shifted)
    assert one.p_value == other.p_value
    assert one.value == pytest.approx(other.value)
    np.testing.assert_allclose(one.interval, other.interval, rtol=1e-9)


@given(SIZES, st.integers(0, 10_000))
def test_the_interval_holds_what_the_test_does_not_refuse(
    sizes: list[tuple[int, int]], seed: int
) -> None:
    strata = drawn(np.random.default_rng(seed), sizes)
    found = difference(strata)
    low, high = found.interval
    assert low <= found.value <= high
    for bound, inwards in ((low, 1.0), (high, -1.0)):
        if math.isfinite(bound):
            step = 1e-6 * inwards
            assert not difference(moved(strata, -(bound + step))).significant
            assert difference(moved(strata, -(bound - step))).significant


@given(SIZES, st.integers(0, 10_000), st.floats(-2.0, 2.0))
def test_swapped_sets_differ_the_other_way(
    sizes: list[tuple[int, int]], seed: int, shift: float
) -> None:
    strata = drawn(np.random.default_rng(seed), sizes, shift)
    found, swapped = difference(strata), difference([(other, one) for one, other in strata])
    assert swapped.value == pytest.approx(-found.value)
    assert swapped.p_value == pytest.approx(found.p_value)
    np.testing.assert_allclose(swapped.interval, [-found.interval[1], -found.interval[0]])


def test_drawn_splits_agree_with_all_of_them(monkeypatch: pytest.MonkeyPatch) -> None:
    strata = drawn(np.random.default_rng(5), [(3, 2)] * 3, shift=0.15)
    exact = difference(strata)
    monkeypatch.setattr(significance, "MOST_SPLITS", 1)
    sampled = difference(strata)
    assert exact.exact
    assert not sampled.exact
    assert sampled.splits == significance.DRAWS
    assert sampled.smallest_p == 1.0 / significance.DRAWS
    assert sampled.p_value == pytest.approx(exact.p_value, abs=0.01)
    np.testing.assert_allclose(sampled.interval, exact.interval, atol=0.02)
    assert sampled == difference(strata)
    assert sampled != difference(strata, seed=2)


def test_sessions_that_tell_more_count_more() -> None:
    """Weights 1/2 and 1 for 1 + 1 and 2 + 2 runs."""
    strata = [
        (np.array([0.0]), np.array([3.0])),
        (np.array([0.0, 0.0]), np.array([0.0, 0.0])),
    ]
    assert difference(strata).value == pytest.approx(1.0)


def test_a_session_without_either_set_tells_nothing() -> None:
    lone: Stratum = (np.array([1.0, 2.0]), np.array([]))
    assert compare_sets([lone], np.random.default_rng(1)) is None
    assert compare_sets([], np.random.default_rng(1)) is None
    whole = (np.array([1.0, 2.0]), np.array([1.5]))
    assert difference([lone, whole]) == difference([whole])


def test_alike_runs_do_not_differ() -> None:
    found = difference([(np.full(3, 0.1 + 0.2), np.full(2, 0.3))] * 2)
    assert found.p_value == 1.0
    assert found.interval == pytest.approx((0.0, 0.0), abs=1e-9)


def test_a_run_without_a_figure_is_refused() -> None:
    with pytest.raises(ShoecalError, match="without a figure"):
        difference([(np.array([1.0, np.nan]), np.array([1.0]))])
