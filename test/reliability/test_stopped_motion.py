from __future__ import annotations

import numpy as np
import pytest

from reliability.row import Row
from reliability.stopped_motion import ROWS, way_back
from ros.adapters.driver_messages import NoMessagesError


@pytest.mark.parametrize("row", ROWS, ids=[row.key for row in ROWS])
def test_a_robot_whose_planner_is_lost_rests(row: Row) -> None:
    """By set points, of which the driver keeps the last."""
    try:
        found = row.run(0, 1, 0, lambda _: None)
    except NoMessagesError as error:
        pytest.skip(str(error))
    assert (found.tried, found.failed) == (1, 0), found.worst


def test_a_way_back_is_seen() -> None:
    """It moved to 0.3 rad, rested, and was pulled back by 0.05 rad after 2 s."""
    times = np.arange(0.0, 3.0, 0.02)
    ways = np.clip(0.3 * times, 0.0, 0.3)
    back = np.where(times > 2.0, np.clip(0.1 * (times - 2.0), 0.0, 0.05), 0.0)
    still = np.full_like(times, -0.4)
    for pulled, expected in ((back, 0.05), (-back, 0.0), (0.0 * back, 0.0)):
        postures = np.column_stack([ways - pulled, still])
        seen = list(zip(times.tolist(), postures, strict=True))
        assert way_back(seen, 2.0) == pytest.approx(expected)
