from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from shoecal_core.recording.join import Piece, TwoSourcesError, in_order, join


@given(st.lists(st.integers(-5, 20)))
def test_in_order_keeps_what_is_later_than_all_before(stamps: list[int]) -> None:
    kept = in_order(np.array(stamps, dtype=np.int64))
    assert kept.tolist() == [
        all(before < stamp for before in stamps[:place]) for place, stamp in enumerate(stamps)
    ]


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
    with pytest.raises(TwoSourcesError) as caught:
        join([piece, later], 2, ("v",))
    assert (caught.value.column, caught.value.stamp_ns) == (1, 4)
