"""Rows of faults: results that are kept, merged and shown."""

from __future__ import annotations

import pytest

from reliability.row import Result, merge


def test_the_worst_of_several_results_is_one_that_failed() -> None:
    merged = merge([Result(5, 0, "9 s", 9.0), Result(5, 1, "3 s", 3.0), Result(2, 0, "1 s", 1.0)])
    assert merged == Result(12, 1, "3 s", 3.0)


def test_nothing_tried_is_said() -> None:
    assert merge([]) == Result(0, 0, "not tried")


def test_no_more_can_fail_than_was_tried() -> None:
    with pytest.raises(ValueError, match="3 of 2"):
        Result(2, 3, "")
