from __future__ import annotations

from shoecal_ros.common.actions import Pacing


def test_another_stage_is_told_at_once_and_the_same_one_is_not() -> None:
    pacing = Pacing()
    assert [pacing.due(stage) for stage in ("planning", "planning", "moving", "moving")] == [
        True, False, True, False,
    ]  # fmt: skip
    assert pacing.due("planning")
