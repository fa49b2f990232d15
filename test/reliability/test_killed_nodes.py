from __future__ import annotations

import pytest

from reliability.killed_nodes import REST_S, Suite, Try, judged
from reliability.live_world import live_world
from reliability.row import Result

pytestmark = pytest.mark.timeout(600)


def test_a_robot_whose_planner_is_killed_comes_to_rest() -> None:
    with live_world() as world:
        found = Suite(world).kill_at("planner", "moving", 3.0, 0)
    assert found.stage == "moving"
    assert found.rest_s < REST_S, found.told
    assert "has fallen silent: start it again" in found.reason


def test_what_was_not_tried_does_not_count() -> None:
    rests, never = (Try("planner", "moving", seconds, 1.0, "") for seconds in (2.0, REST_S + 1.0))
    assert judged([rests, rests], 2, "") == Result(2, 0, rests.told, 2.0)
    assert judged([rests, never], 2, "").failed == 1
    for found, count, tried, failed in (
        ([], 5, 1, 1),
        ([rests, rests], 5, 3, 1),
        ([never, rests], 5, 3, 2),
        ([rests, rests], 2, 2, 1),  # the calibration after the last one did not begin
        ([rests, never], 2, 2, 1),
    ):
        result = judged(found, count, "not told")
        assert (result.tried, result.failed, result.worst) == (tried, failed, "not told")
