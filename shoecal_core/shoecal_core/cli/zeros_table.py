"""What feet read in the air, and what the robot weighs, for a terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from shoecal_core.cli.tables import new_table
from shoecal_core.estimation.data_sheets import weight_text
from shoecal_core.estimation.weight import Weighed
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.zeros import ZeroFigures


def zeros_table(zeros: Sequence[ZeroFigures]) -> Table:
    """One line a run and foot."""
    table = new_table("Zeros: vertical force that a foot shows in the air (95 % interval)")
    for name in ("run", "foot", "zero (N)", "left by the calibration (N)"):
        table.add_column(name, justify="right")
    for one in zeros:
        half = 0.5 * (one["ci95"][1] - one["ci95"][0])
        left = f"{one['left_n']:+.1f}" if "left_n" in one else "-"
        table.add_row(str(one["run"]), one["foot"], f"{one['fz_n']:.1f} ± {half:.1f}", left)
    return table


def weight_line(weighed: Weighed | None, robot: Robot) -> str:
    """The weight that all gains rest on."""
    if weighed is not None:
        return f"weight: {weight_text(weighed, robot)}"
    return (
        f"weight: {robot.mass:.2f} kg with shoes by the robot file (standard uncertainty "
        f"{robot.mass_std:.2f} kg)"
    )


def weight_json(weighed: Weighed | None, robot: Robot) -> dict[str, object]:
    """The same for result files."""
    file: dict[str, object] = {"robot_file_kg": robot.mass, "robot_file_std_kg": robot.mass_std}
    return file if weighed is None else {**file, **weighed.to_json()}
