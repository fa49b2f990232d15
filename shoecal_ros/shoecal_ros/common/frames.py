"""Names of the frames on TF and in headers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from shoecal_core.model.robot import Robot
from shoecal_core.sensing.shoe import FEET
from shoecal_core.settings import SettingError, Settings, setting

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
    """

    base: str
    soles: tuple[str, str]


@dataclass(frozen=True)
class FrameSettings(Settings):
    """Parameters of the nodes that name frames; all of them are to have the same."""

    base_frame: str = setting("", "", "frame of the robot's root link; empty: the URDF's root link")
    left_sole_frame: str = setting("l_sole", "", "frame of the left shoe's floor side")
    right_sole_frame: str = setting("r_sole", "", "frame of the right shoe's floor side")
    frame_prefix: str = setting(
        "", "", "before all frames, as that of robot_state_publisher: left/ gives left/l_sole"
    )

    def frames(self, robot: Robot) -> Frames:
        """The names for a robot.

        Raises:
            SettingError: where two frames have one name, or the robot's own tree has a sole's name
                at another place.
        """
        base = self.base_frame or str(robot.model.frames[_ROOT_LINK].name)
        soles = (self.left_sole_frame, self.right_sole_frame)
        if len({base, *soles}) < 3 or not all(soles):
            raise SettingError(
                "left_sole_frame", f"'{base}', '{soles[0]}' and '{soles[1]}' must be three frames"
            )
        for foot, name in enumerate(soles):
            self._check_sole(robot, foot, name)
        left, right = (f"{self.frame_prefix}{name}" for name in soles)
        return Frames(f"{self.frame_prefix}{base}", (left, right))

    def _check_sole(self, robot: Robot, foot: int, name: str) -> None:
        model, own = robot.model, robot.feet[foot]
        if not model.existFrame(name, pin.FrameType.BODY):
            return
        link = model.frames[model.getFrameId(name, pin.FrameType.BODY)]
        apart = pin.log6(link.placement.actInv(own.placement)).vector
        if link.parentJoint != own.joint or np.abs(apart).max() > SAME_PLACE:
            raise SettingError(
                f"{FEET[foot]}_sole_frame",
                f"the URDF has a link '{name}' that is not the floor side of the {FEET[foot]} "
                f"shoe; choose another name, for example '{FEET[foot]}_shoe'",
            )
