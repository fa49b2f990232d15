"""Which robot, on which shoes: parameters that most nodes share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from shoecal_core.robot.robot import Robot
from shoecal_core.robot.robot_file import load_robot, shoe_file_of
from shoecal_core.settings import Settings, setting
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.workspace import config_dir


@dataclass(frozen=True)
class RobotFiles(Settings):
    """Parameters `robot_file` and `shoe_file`."""

    robot_file: str = setting("", "", "robot file; empty: robots/nao.yaml of the configuration")
    shoe_file: str = setting(
        "", "", "shoe file; empty: ROBOT_shoe.yaml in ../shoes or next to ROBOT.yaml"
    )

    @cached_property
    def robot_path(self) -> Path:
        """Of the robot file."""
        return Path(self.robot_file or config_dir() / "robots" / "nao.yaml")

    @cached_property
    def shoe_path(self) -> Path:
        """Of the shoe file; FileError where none is named and none belongs to the robot file."""
        return Path(self.shoe_file) if self.shoe_file else shoe_file_of(self.robot_path)

    def load_shoe(self) -> Shoe:
        """The shoes; FileError where the file cannot be used."""
        return load_shoe(self.shoe_path)

    def load_robot(self) -> Robot:
        """The robot in its shoes; FileError where a file cannot be used."""
        return load_robot(self.robot_path, self.load_shoe())
