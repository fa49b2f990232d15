"""The simulated robot goes from one double support to the next by its own steps."""

from __future__ import annotations

from collections.abc import Callable

from shoecal_core.planning.motion import Motion
from shoecal_core.planning.steps import Stepper, require_steps_left
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.simulation.robot import SimulatedRobot

SETTLE_S = 1.0
"""InitialStance still after a step, before joint angles are measured for the next one [s]."""
PERIOD_S = 0.02
"""How often the robot is looked at while it steps [s]."""

Watch = Callable[[Motion, float], None]
"""Called with the step and the time since its start [s], every PERIOD_S."""


def walk(
    simulated: SimulatedRobot,
    stepper: Stepper,
    goal: DoubleSupport,
    watch: Watch = lambda *_: None,
) -> list[Motion]:
    """Step until the feet stand in a double support, by the robot's own encoders.

    Args:
        simulated: stands on both feet.
        stepper: plans its steps.
        goal: where to go.
        watch: looks on.

    Returns:
        The steps that were taken; none where it stood there before.

    Raises:
        StepError: when no step, or too many, lead there.
        RobotFellError: when it falls.
        StartError: when it no longer stands as a step must start.
    """
    taken: list[Motion] = []
    while (motion := stepper.step(simulated.joints().angles, goal)) is not None:
        require_steps_left(len(taken), goal)
        take(simulated, motion, watch)
        taken.append(motion)
    return taken


def take(simulated: SimulatedRobot, motion: Motion, watch: Watch = lambda *_: None) -> None:
    """Let the robot follow a motion, and then stand still.

    Raises:
        RobotFellError: when it falls.
    """
    start = simulated.time
    simulated.command(JointTrajectory(motion.joint_names, motion.time, motion.positions))
    for index in range(1, round((motion.duration + SETTLE_S) / PERIOD_S) + 1):
        simulated.step_to(start + index * PERIOD_S)
        simulated.check_upright()
        watch(motion, index * PERIOD_S)
