"""Parts of a streamed motion."""

from __future__ import annotations

import dataclasses
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from ros.bodies import nao
from shoecal_core.planning.horizon.rolling import PlanningError
from shoecal_core.planning.planner import Planner
from shoecal_core.planning.posture import stance
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.worker import Link
from shoecal_ros.planner import planning_work

LINK = cast(Link, SimpleNamespace(progress=lambda _: None, canceled=lambda: False))
# Too few iterations for any solution: nothing can be planned.
HOPELESS = dataclasses.replace(PlannerSettings(), solver="ipopt", iterations=1, tolerance=1e-9)
ANGLES = nao().from_legs(stance(nao(), DoubleSupport(0.02, -0.11, 0.1)))


def test_places_that_no_later_part_comes_nearer_to_are_given_up() -> None:
    cop = Planner(nao(), HOPELESS).standing(ANGLES).cop
    targets = cop + np.array([[0.03, 0.0], [0.0, 0.04]])
    part = planning_work.plan_chunk(
        LINK, RobotFiles(), HOPELESS, ANGLES, "landmarks", targets, states=8
    )
    assert part.motion is None
    assert len(part.targets) == 0
    assert part.nearest == pytest.approx([0.03, 0.04])


def test_a_motion_whose_first_part_leads_nowhere_is_refused() -> None:
    with pytest.raises(PlanningError, match="no motion towards any"):
        planning_work.plan_chunk(LINK, RobotFiles(), HOPELESS, ANGLES, "landmarks", None, states=8)
