from __future__ import annotations

import pytest

from reliability.killed_nodes import REST_S, Suite
from reliability.live_world import live_world

pytestmark = pytest.mark.timeout(600)


def test_a_robot_whose_planner_is_killed_comes_to_rest() -> None:
    with live_world() as world:
        found = Suite(world).kill_at("planner", "moving", 3.0, 0)
    assert found.stage == "moving"
    assert found.rest_s < REST_S, found.told
    assert "has fallen silent: start it again" in found.reason
