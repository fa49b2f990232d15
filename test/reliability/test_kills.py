"""Processes that are killed while they write."""

from __future__ import annotations

import pytest

from reliability import killed_recording, killed_saving
from reliability.row import Row


@pytest.mark.parametrize(("row", "count"), [(killed_recording.ROW, 20), (killed_saving.ROW, 20)])
def test_nothing_is_lost_that_was_whole(row: Row, count: int) -> None:
    found = row.run(0, count, 1, lambda _: None)
    assert (found.tried, found.failed) == (count, 0), found.worst
