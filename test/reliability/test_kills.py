"""Processes that are killed while they write."""

from __future__ import annotations

from dataclasses import replace

import pytest

from reliability import killed_recording, killed_saving
from reliability.row import Row


@pytest.mark.parametrize(("row", "count"), [(killed_recording.ROW, 20), (killed_saving.ROW, 20)])
def test_nothing_is_lost_that_was_whole(row: Row, count: int) -> None:
    found = row.run(0, count, 1, lambda _: None)
    assert (found.tried, found.failed) == (count, 0), found.worst


def test_a_calibration_of_mixed_content_is_not_whole() -> None:
    one, other = killed_saving.made_from(1), killed_saving.made_from(2)
    both = {each.id: each for each in (one, other)}
    assert killed_saving.name_of(one, both) == "made-1"
    mixed = replace(one, parameters=replace(one.parameters, gain=other.parameters.gain))
    assert killed_saving.name_of(mixed, both) == "made-1 with other content"
    assert killed_saving.name_of(replace(one, id="made-3"), both) == "made-3 with other content"
