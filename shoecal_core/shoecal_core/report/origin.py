"""Where a recording is from, as a page shows it: simulated or real, which session, which files."""

from __future__ import annotations

from collections.abc import Iterable

from shoecal_core.recording.session import Session
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.shoe import Shoe

SHORT = 12
"""Digits of a hash that a page shows."""


def origin(session: Session, runs: Iterable[int]) -> str:
    """Whether some runs were simulated: those have a truth file."""
    if any(session.truth_path(run).is_file() for run in runs):
        return "The recorded robot, its shoes and the floor are simulated."
    return "Nothing in the session says that it was simulated: taken as recorded on hardware."


def robot_text(robot: Robot) -> str:
    """Name and files of a robot."""
    return f"{robot.name}, file {robot.digest[:SHORT]}, URDF {robot.urdf_digest[:SHORT]}"


def shoe_text(shoe: Shoe) -> str:
    """Name and file of a pair of shoes."""
    return f"{shoe.name}, file {shoe.digest[:SHORT]}"
