"""Progress of the demo."""

from __future__ import annotations

import pytest
from shoecal_msgs.action import Calibrate

from shoecal_ros.demo import step_text


@pytest.mark.parametrize(
    ("stage", "text"),
    [("drawing", "drawing"), ("moving", "moving, run 7 of 7"), ("applying", "applying")],
)
def test_runs_are_counted_while_they_are_recorded(stage: str, text: str) -> None:
    assert step_text(Calibrate.Feedback(stage=stage, support=7, supports=7)) == text
