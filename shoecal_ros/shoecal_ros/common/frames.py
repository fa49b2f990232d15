"""Names of the frames on TF and in headers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shoecal_core.robot.robot import Robot
from shoecal_core.settings import SettingError, Settings, setting
from shoecal_core.shoe.shoe import FEET
from shoecal_ros.common.conversions import SOLES

SAME_PLACE = 1e-3
"""m and rad; frames nearer to each other than this are one."""
_ROOT_LINK = 2
"""Of Pinocchio's frames: after the universe and the free-flying base."""


@dataclass(frozen=True)
class Frames:
    """Names as they stand in headers.

    Attributes:
        base: root link of the robot.
        soles: floor side of the left and of the right shoe.
        links: which of them are links of the URDF, so that who publishes its links publishes them.
    """

    base: str
    soles: tuple[str, str]
    links: tuple[bool, bool]


@dataclass(frozen=True)
class FrameSettings(Settings):
    """Parameters of the nodes that name frames; all of them are to have the same."""

    base_frame: str = setting("", "", "frame of the robot's root link; empty: the URDF's root link")
    left_sole_frame: str = setting(
        SOLES[0],
        "",
        "frame of the left shoe's floor side; l_sole becomes left_shoe where the URDF has a link "
        "l_sole at another place",
    )
    right_sole_frame: str = setting(
        SOLES[1],
        "",
        "frame of the right shoe's floor side; r_sole becomes right_shoe likewise",
    )
    frame_prefix: str = setting(
        "", "", "before all frames, as that of robot_state_publisher: left/ gives left/l_sole"
    )

    def frames(self, robot: Robot) -> Frames:
        """The names for a robot.

        Raises:
            SettingError: where two frames have one name, or the robot's own tree has a sole's name
                at another place, unless that is the default.
        """
        base = self.base_frame or str(robot.model.frames[_ROOT_LINK].name)
        soles = (
            _default_replaced(robot, 0, self.left_sole_frame),
            _default_replaced(robot, 1, self.right_sole_frame),
        )
        if len({base, *soles}) < 3 or not all(soles):
            raise SettingError(
                "left_sole_frame", f"'{base}', '{soles[0]}' and '{soles[1]}' must be three frames"
            )
        for foot, name in enumerate(soles):
            if _is_elsewhere(robot, foot, name):
                raise SettingError(
                    f"{FEET[foot]}_sole_frame",
                    f"the URDF has a link '{name}' that is not the floor side of the {FEET[foot]} "
                    f"shoe; choose another name, for example '{FEET[foot]}_shoe'",
                )
        left, right = (f"{self.frame_prefix}{name}" for name in soles)
        links = (_is_link(robot, soles[0]), _is_link(robot, soles[1]))
        return Frames(f"{self.frame_prefix}{base}", (left, right), links)


def _default_replaced(robot: Robot, foot: int, name: str) -> str:
    """A sole's name; another one than the default where a link at another place has that."""
    taken = name == SOLES[foot] and _is_elsewhere(robot, foot, name)
    return f"{FEET[foot]}_shoe" if taken else name


def _is_link(robot: Robot, name: str) -> bool:
    return bool(robot.model.existFrame(name, pin.FrameType.BODY))


def _is_elsewhere(robot: Robot, foot: int, name: str) -> bool:
    """Whether a link of this name is not the floor side of the foot's shoe."""
    if not _is_link(robot, name):
        return False
    model, own = robot.model, robot.feet[foot]
    link = model.frames[model.getFrameId(name, pin.FrameType.BODY)]
    apart = pin.log6(link.placement.actInv(own.placement)).vector
    return bool(link.parentJoint != own.joint or np.abs(apart).max() > SAME_PLACE)
