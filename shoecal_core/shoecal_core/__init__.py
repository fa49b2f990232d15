"""shoecal: robots that calibrate the force sensors in their own feet.

The method only: no ROS, no serial port, no wall clock. What a script needs is imported from here;
each name's module, and what that needs, is loaded when the name is first used.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shoecal_core.diagnosis.diagnose import diagnose
    from shoecal_core.errors import ShoecalError
    from shoecal_core.estimation.calibration import (
        Calibration,
        load_calibration,
        save_calibration,
    )
    from shoecal_core.planning.planner import Planner
    from shoecal_core.recording.align import interpolate_joints
    from shoecal_core.recording.session import Session
    from shoecal_core.robot.double_support import DoubleSupport
    from shoecal_core.robot.kinematics import Kinematics
    from shoecal_core.robot.robot_file import load_robot
    from shoecal_core.shoe.shoe_file import load_shoe
    from shoecal_core.simulation.robot import SimulatedRobot
    from shoecal_core.workflows.calibrate import calibrate_session
    from shoecal_core.workflows.evaluation import evaluate_session

__all__ = [
    "Calibration",
    "DoubleSupport",
    "Kinematics",
    "Planner",
    "Session",
    "ShoecalError",
    "SimulatedRobot",
    "calibrate_session",
    "diagnose",
    "evaluate_session",
    "interpolate_joints",
    "load_calibration",
    "load_robot",
    "load_shoe",
    "save_calibration",
]

_MODULES = {
    "Calibration": "estimation.calibration",
    "DoubleSupport": "robot.double_support",
    "Kinematics": "robot.kinematics",
    "Planner": "planning.planner",
    "Session": "recording.session",
    "ShoecalError": "errors",
    "SimulatedRobot": "simulation.robot",
    "calibrate_session": "workflows.calibrate",
    "diagnose": "diagnosis.diagnose",
    "evaluate_session": "workflows.evaluation",
    "interpolate_joints": "recording.align",
    "load_calibration": "estimation.calibration",
    "load_robot": "robot.robot_file",
    "load_shoe": "shoe.shoe_file",
    "save_calibration": "estimation.calibration",
}


def __getattr__(name: str) -> object:
    """A public name, from its module."""
    if name not in _MODULES:
        raise AttributeError(f"module '{__name__}' has no attribute '{name}'")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return __all__
