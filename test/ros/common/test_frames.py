from __future__ import annotations

import dataclasses

import numpy as np
import pinocchio as pin
import pytest

from ros.bodies import ODD, ODD_SHOE, nao
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot
from shoecal_core.settings import SettingError
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_ros.common.frames import Frames, FrameSettings


def with_link(name: str, *, above: float) -> Robot:
    """A NAO whose own tree has a link on its left foot, so far above the shoe's floor side [m]."""
    robot = nao()
    model, foot = robot.model.copy(), robot.feet[0]
    place = foot.placement * pin.SE3(np.eye(3), np.array([0.0, 0.0, above]))
    model.addFrame(pin.Frame(name, foot.joint, 0, place, pin.FrameType.BODY))
    return dataclasses.replace(robot, model=model)


def test_the_base_is_the_root_of_the_urdf() -> None:
    assert FrameSettings().frames(nao()) == Frames(
        "base_link", ("l_sole", "r_sole"), (False, False)
    )
    odd = load_robot(ODD, load_shoe(ODD_SHOE))
    root = odd.model.frames[2].name
    assert FrameSettings().frames(odd).base == root
    assert FrameSettings(base_frame="torso").frames(odd).base == "torso"


def test_a_prefix_stands_before_all() -> None:
    settings = FrameSettings(frame_prefix="left/", left_sole_frame="l_shoe")
    assert settings.frames(nao()) == Frames(
        "left/base_link", ("left/l_shoe", "left/r_sole"), (False, False)
    )


def test_a_frame_of_the_robot_s_own_tree_is_not_moved() -> None:
    settings = FrameSettings(left_sole_frame="foot")
    with pytest.raises(SettingError, match="the URDF has a link 'foot'") as caught:
        settings.frames(with_link("foot", above=0.022))
    assert "left_sole_frame" in str(caught.value)
    assert "'left_shoe'" in str(caught.value)
    # At the same place it is the same, and whoever publishes the links publishes it.
    same = FrameSettings().frames(with_link("l_sole", above=0.0))
    assert (same.soles, same.links) == (("l_sole", "r_sole"), (True, False))
    # A NAO's own sole is above the shoe's: by default the shoe's has another name.
    nao_s = FrameSettings().frames(with_link("l_sole", above=0.022))
    assert (nao_s.soles, nao_s.links) == (("left_shoe", "r_sole"), (False, False))


@pytest.mark.parametrize("left", ["r_sole", "base_link", ""])
def test_three_frames_have_three_names(left: str) -> None:
    with pytest.raises(SettingError, match="three frames"):
        FrameSettings(left_sole_frame=left).frames(nao())
