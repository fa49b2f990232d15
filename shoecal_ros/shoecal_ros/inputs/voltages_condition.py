"""How voltages come, for the diagnostics of nodes that receive them."""

from __future__ import annotations

from shoecal_ros.common.health import Condition
from shoecal_ros.inputs.voltages import VoltageInput


def voltages_condition(voltages: VoltageInput) -> Condition:
    """What is wrong with them, and how many come."""
    figures = {
        **voltages.heard.figures(),
        "lost_frames": str(voltages.lost),
        "left_out_frames": str(voltages.left_out),
    }
    return Condition.of(voltages.problem, "voltages come", figures)
