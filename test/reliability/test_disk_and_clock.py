"""Full disks, clocks that are set, files of another robot."""

from __future__ import annotations

import pytest

from reliability import clock_jumps, full_disk, other_robot
from reliability.row import Row


@pytest.mark.parametrize(
    ("row", "count"), [(full_disk.ROW, 25), (clock_jumps.ROW, 9), (other_robot.ROW, 30)]
)
def test_it_holds(row: Row, count: int) -> None:
    found = row.run(0, count, 1, lambda _: None)
    assert (found.tried, found.failed) == (count, 0), found.worst
