"""What the robot weighs, for a terminal and for result files."""

from __future__ import annotations

from shoecal_core.estimation.checks.data_sheets import weight_text
from shoecal_core.estimation.weight import Weighed
from shoecal_core.robot.robot import Robot


def weight_line(weighed: Weighed | None, robot: Robot) -> str:
    """The weight that all gains rest on."""
    if weighed is not None:
        return f"weight: {weight_text(weighed, robot)}"
    return (
        f"weight: {robot.mass:.2f} kg by the files of robot and shoes (standard uncertainty "
        f"{robot.mass_std:.2f} kg)"
    )


def weight_json(weighed: Weighed | None, robot: Robot) -> dict[str, object]:
    """The same for result files."""
    file: dict[str, object] = {"robot_file_kg": robot.mass, "robot_file_std_kg": robot.mass_std}
    return file if weighed is None else {**file, **weighed.to_json()}
