from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.arrays import FloatArray
from shoecal_core.recording.join import (
    OverlapError,
    Piece,
    at_common_instants,
    in_order,
    join,
    sampled_apart,
)


@given(st.lists(st.integers(-5, 20)))
def test_in_order_keeps_as_many_as_can_be(stamps: list[int]) -> None:
    kept = np.array(stamps, dtype=np.int64)[in_order(np.array(stamps, dtype=np.int64))]
    assert (np.diff(kept) > 0).all()
    longest: list[int] = []
    for place, stamp in enumerate(stamps):
        before = [
            length for one, length in zip(stamps[:place], longest, strict=True) if one < stamp
        ]
        longest.append(1 + max(before, default=0))
    assert len(kept) == max(longest, default=0)


def test_one_stamp_far_ahead_is_left_out_alone() -> None:
    stamps = np.arange(1000)
    stamps[200] = 10**9
    assert np.flatnonzero(~in_order(stamps)).tolist() == [200]
    # Of several with one stamp the first.
    assert in_order(np.array([1, 2, 2, 2, 3])).tolist() == [True, True, False, False, True]


stamp_lists = st.lists(st.integers(0, 9), unique=True, min_size=1).map(sorted)


@given(stamp_lists, stamp_lists)
def test_join_puts_every_value_in_its_place(first: list[int], second: list[int]) -> None:
    pieces = [
        Piece(
            np.array(stamps),
            np.array([column]),
            {"v": np.array(stamps, dtype=np.float64)[:, None] + column},
        )
        for column, stamps in ((2, first), (0, second))
    ]
    stamps, joined = join(pieces, 3, ("v", "other"))
    assert stamps.tolist() == sorted({*first, *second})
    for row, stamp in enumerate(stamps.tolist()):
        expected = [
            stamp + 0 if stamp in second else np.nan,
            np.nan,
            stamp + 2 if stamp in first else np.nan,
        ]
        np.testing.assert_array_equal(joined["v"][row], expected)
    assert np.isnan(joined["other"]).all()


def test_two_sources_of_one_column() -> None:
    piece = Piece(np.array([3, 4]), np.array([1]), {"v": np.zeros((2, 1))})
    later = Piece(np.array([4, 5]), np.array([0, 1]), {"v": np.zeros((2, 2))})
    with pytest.raises(OverlapError) as caught:
        join([piece, later], 2, ("v",))
    assert (caught.value.column, caught.value.stamp_ns) == (1, 4)


QUANTITIES = ("value", "status", "sequence", "temperature")
MS = 1_000_000


def piece(
    stamps_ms: list[int], column: int, value: list[float], status: list[float] | None = None
) -> Piece:
    def column_of(numbers: list[float]) -> FloatArray:
        return np.array(numbers, dtype=np.float64)[:, None]

    count = len(stamps_ms)
    values = {
        "value": column_of(value),
        "status": column_of(status or [0.0] * count),
        "sequence": column_of([float(index) for index in range(count)]),
        "temperature": column_of([20.0] * count),
    }
    return Piece(np.array(stamps_ms) * MS, np.array([column]), values)


def test_boards_of_one_clock_are_left_as_they_are() -> None:
    left, right = piece([0, 10, 20, 30], 0, [1.0] * 4), piece([0, 20], 1, [1.0] * 2)
    assert not sampled_apart([[left], [right]])
    assert not sampled_apart([[left]])
    assert sampled_apart([[left], [piece([1, 11, 20, 31], 1, [1.0] * 4)]])


def test_values_are_interpolated_by_their_times() -> None:
    """Never beyond a source's own time, never over a gap; the worse status counts."""
    fast = piece(
        [0, 10, 13, 30, 40, 400, 410], 0, [0.0, 10.0, 13.0, 30.0, 40.0, 400.0, 410.0],
        [0, 0, 0, 1, 0, 0, 0],
    )  # fmt: skip
    slow = piece([-5, 5, 20, 40, 200, 405], 1, [1.0] * 6)
    left, right = at_common_instants([[fast], [slow]], 2, QUANTITIES)
    np.testing.assert_array_equal(left.stamp_ns, slow.stamp_ns)
    np.testing.assert_array_equal(right.values["value"], slow.values["value"])
    nan = np.nan
    np.testing.assert_allclose(left.values["value"][:, 0], [nan, 5.0, 20.0, 40.0, nan, 405.0])
    np.testing.assert_array_equal(left.values["status"][:, 0], [nan, 0, 1, 0, nan, 0])
    np.testing.assert_array_equal(left.values["sequence"][:, 0], [nan, 0, 2, 4, nan, 5])


def test_slow_converters_have_no_gaps() -> None:
    """Ten samples a second: their own period is no gap."""
    stamps = list(range(0, 2000, 120))
    slow = piece(stamps, 0, [float(stamp) for stamp in stamps])
    other = piece([stamp + 50 for stamp in stamps[:-1]], 1, [0.0] * (len(stamps) - 1))
    found, _ = at_common_instants([[slow], [other]], 2, QUANTITIES)
    np.testing.assert_allclose(found.values["value"][:, 0], [stamp + 50 for stamp in stamps[:-1]])
