from __future__ import annotations

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from core.planning.bodies import NAMES, load_body
from shoecal_core.planning.landmarks import sensing_hull
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.double_support import DoubleSupport

supports = st.builds(
    DoubleSupport, st.floats(-0.1, 0.1), st.floats(-0.2, -0.08), st.floats(-0.6, 0.6)
)


@pytest.mark.parametrize("name", NAMES)
@given(support=supports)
def test_the_polygon_of_one_foot_is_its_own(name: str, support: DoubleSupport) -> None:
    robot, pose = load_body(name).robot, FootPose.of(support)
    left, right = (shapely.Polygon(foot.sensing_polygon) for foot in robot.feet)
    assert SupportPhase.LEFT.polygon(robot, pose).equals_exact(left, 1e-12)
    placed = SupportPhase.RIGHT.polygon(robot, pose)
    corners = support.left_to_right(np.array(placed.exterior.coords))
    np.testing.assert_allclose(corners, right.exterior.coords, atol=1e-12)
    both = SupportPhase.BOTH.polygon(robot, pose)
    assert both.equals_exact(sensing_hull(robot, support), 1e-12)
    assert both.buffer(1e-9).contains(left)
    assert both.buffer(1e-9).contains(placed)


def test_the_polygon_of_the_right_foot_while_the_left_one_is_in_the_air() -> None:
    """Seen from the left sole the floor is lower then; places along it are the same."""
    robot, support = load_body("nao").robot, DoubleSupport(0.02, -0.12, 0.2)
    down = FootPose.of(support)
    detect_lifted_foot = FootPose(down.rotation, down.translation - [0.0, 0.0, 0.02])
    assert SupportPhase.RIGHT.polygon(robot, detect_lifted_foot).equals_exact(
        SupportPhase.RIGHT.polygon(robot, down), 1e-12
    )


def test_the_other_foot() -> None:
    assert [one.other for one in SupportPhase] == [
        SupportPhase.BOTH,
        SupportPhase.RIGHT,
        SupportPhase.LEFT,
    ]


def test_which_feet_stand() -> None:
    assert [one.feet for one in SupportPhase] == [(True, True), (True, False), (False, True)]
