"""Drafts of humanoids whose descriptions are public (`make descriptions` installs them)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from humanoids import HUMANOIDS, Humanoid, descriptions, icubs
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.draft import draft_robot, prove
from shoecal_core.drafting.soles import SoleSize
from shoecal_core.drafting.text import robot_text, shoe_text
from shoecal_core.errors import FileError

FOLDER = descriptions()
ICUBS = icubs()
pytestmark = pytest.mark.skipif(
    FOLDER is None or not ICUBS, reason="descriptions are not installed (make descriptions)"
)

TURNED = ("iCubGenova03", "iCubLisboa01", "iCubNancy01")
"""Their feet's meshes are turned by a quarter against the links."""
WITHOUT_SENSORS = "iCubLisboa01"
SOLES = {"icub": "l_sole", "talos": "left_sole_link", "romeo": "l_sole"}
"""Links that makers put on the floor side of the left foot themselves."""
REFUSED = {
    "simple_humanoid_description/urdf/simple_humanoid.urdf": "so its sole is not known",
    "anymal_b_simple_description/robots/anymal.urdf": "feet",
    "bolt_description/robots/bolt.urdf": "its legs have 6 motors",
    "alex_description/urdf/alex_nub_hands.urdf": "are arms",
    "ur_description/urdf/ur5_robot.urdf": "",
    "panda_description/urdf/panda.urdf": "",
}
"""Robots that are no humanoids on two legs, and one whose feet have no shape."""


def folder() -> Path:
    assert FOLDER is not None
    return FOLDER


@pytest.mark.parametrize("humanoid", HUMANOIDS, ids=lambda humanoid: humanoid.name)
def test_the_draft_loads(humanoid: Humanoid) -> None:
    urdf = folder() / humanoid.urdf
    draft = draft_robot(urdf, humanoid.name, six_axis=humanoid.six_axis)
    prove(draft, robot_text(draft, str(urdf)), shoe_text(draft))
    assert len(draft.leg_names) == 12
    assert (draft.six_axis[0] is not None) == (humanoid.name in ("icub", "talos"))
    length, width = np.ptp(draft.soles[0].outline, axis=0)
    assert 0.15 < length < 0.25
    assert 0.05 < width < 0.14
    left, right = (
        sole.outline * [1.0, side] for sole, side in zip(draft.soles, (1, -1), strict=True)
    )
    assert np.allclose(left.min(axis=0), right.min(axis=0), atol=2e-3)
    sole = SOLES.get(humanoid.name)
    if sole is not None:
        assert abs(_height(draft.body, sole) - draft.soles[0].in_base.translation[2]) < 2e-3


@pytest.mark.parametrize("urdf", ICUBS, ids=lambda urdf: urdf.parent.name)
def test_every_icub(urdf: Path) -> None:
    """Their bases look backwards, and a gyroscope in each foot has `ft` in its name, too."""
    size = None
    if urdf.parent.name in TURNED:
        with pytest.raises(FileError, match="61 mm long and 156 mm wide and overlap in the zero"):
            draft_robot(urdf, "icub")
        size = SoleSize(back=0.05, front=0.11, inner=0.03, outer=0.04, height=0.043)
    draft = draft_robot(urdf, "icub", sole=size)
    prove(draft, robot_text(draft, str(urdf)), shoe_text(draft))
    names = [] if urdf.parent.name == WITHOUT_SENSORS else ["l_foot_ft_sensor", "r_foot_ft_sensor"]
    assert [sensor.name for sensor in draft.six_axis if sensor] == names
    assert np.allclose(draft.legs.forward, [-1.0, 0.0, 0.0])
    assert draft.other_sensors == ["l_leg_ft_sensor", "r_leg_ft_sensor"]


def _height(body: Body, link: str) -> float:
    """Of a link over the base, in the zero pose [m]."""
    frame = body.model.frames[body.model.getFrameId(link, pin.FrameType.BODY)]
    placed = body.placements[frame.parentJoint] * frame.placement
    return float(placed.translation[2])


@pytest.mark.parametrize("file", REFUSED)
def test_other_robots_are_refused(file: str) -> None:
    with pytest.raises(FileError) as error:
        draft_robot(folder() / file, "robot")
    assert REFUSED[file] in error.value.problem
