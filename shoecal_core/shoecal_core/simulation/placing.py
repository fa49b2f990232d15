"""Putting a simulated robot where a recorded one stood."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.simulation.robot import SimulatedRobot


def place_showing(sim: SimulatedRobot, joint_angles: FloatArray) -> None:
    """Put the robot down so that, at rest, its encoders show these angles.

    Servos give under load, so a robot that is commanded what another one showed stands lower than
    that one, and its feet push each other otherwise. What it misses is added to its command.

    Args:
        sim: to put down.
        joint_angles: (m,) as a recorded robot's encoders showed them [rad].

    Raises:
        SupportNotReachedError: when the soles are not level or it does not come to rest.
        RobotFellError: when it falls.
    """
    sim.place(joint_angles)
    commanded = 2.0 * joint_angles - sim.joints().angles
    for motor in sim.robot.shared:
        commanded[motor.joint] = motor.ratio * commanded[motor.leader]
    sim.place(np.clip(commanded, sim.robot.lower, sim.robot.upper))
