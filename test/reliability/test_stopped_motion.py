from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from reliability.stopped_motion import KINDS, off_course, run
from ros.adapters.driver_messages import NoMessagesError
from shoecal_core.arrays import FloatArray

BUSY_S = 1.5
"""Granted to messages while other tests run: what is left of a motion lasts for longer."""


@pytest.mark.parametrize("do", ["kill", "pause"])
@pytest.mark.parametrize("victims", KINDS, ids=" and ".join)
def test_a_robot_whose_planner_is_lost_rests(
    victims: tuple[str, ...], do: Literal["kill", "pause"]
) -> None:
    """By set points, of which the driver keeps the last."""
    try:
        found = run(victims, do, 0, 1, 0, lambda _: None, granted_s=BUSY_S)
    except NoMessagesError as error:
        pytest.skip(str(error))
    assert (found.tried, found.failed) == (1, 0), found.worst


TIMES = np.arange(0.0, 3.0, 0.02)
STILL = np.full_like(TIMES, -0.4)
RESUMED_S = 2.0


def moving(since: FloatArray) -> list[tuple[float, FloatArray]]:
    """It moved to 0.3 rad, rested, and moved on by some (T,) [rad] after the pause."""
    ways = np.clip(0.3 * TIMES, 0.0, 0.3) + np.where(TIMES > RESUMED_S, since, 0.0)
    return list(zip(TIMES.tolist(), np.column_stack([ways, STILL]), strict=True))


def way(first: float, last: float) -> FloatArray:
    ways = np.linspace(first, last, 501)
    return np.column_stack([ways, np.full(501, -0.4)])


def test_what_was_not_sent_since_the_pause_is_seen() -> None:
    since = np.clip(0.1 * (TIMES - RESUMED_S), 0.0, 0.05)
    still, on, back = moving(0.0 * since), moving(since), moving(-since)
    last = way(0.0, 0.3)
    for asleep in (False, True):
        assert off_course(still, last, [], RESUMED_S, planner_slept=asleep) == 0.0
        for pulled in (on, back):
            found = off_course(pulled, last, [], RESUMED_S, planner_slept=asleep)
            assert found == pytest.approx(0.05, abs=1e-3)
        sent = [(2.1, way(0.3, 0.35))]
        assert off_course(on, last, sent, RESUMED_S, planner_slept=asleep) < 1e-3
        # What it was doing may be done.
        assert off_course(on, way(0.0, 0.35), [], RESUMED_S, planner_slept=asleep) < 1e-3
    # Also a plan that turns may go on, but from where the robot is.
    turned = [(2.1, way(0.3, 0.25))]
    assert off_course(back, last, turned, RESUMED_S, planner_slept=True) < 1e-3
    late = [(2.1, way(0.26, 0.25))]
    found = off_course(back, last, late, RESUMED_S, planner_slept=True)
    assert found == pytest.approx(0.04, abs=1e-3)
