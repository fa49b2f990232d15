"""Where a robot's links are while gravity bends its joints.

Encoders sit at the motors, and trajectories say where motors shall be. Between motor and link gears
and brackets give, servos need an error to hold a torque, and gears have play: a joint that holds
the torque tau is off by

    delta = -sag * tau / tau_max - play / 2 * sign(tau)

On one foot this lowers the other foot and brings it nearer to the one that stands.
"""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.legs import FootPose
from shoecal_core.planning.support_phase import SupportPhase
from shoecal_core.robot.robot import Robot
from shoecal_core.robot.standing import feet_gap

_CROSSING = 0.02
"""Of a torque limit; below it a joint is on its way from one side of its play to the other."""


def deflected(robot: Robot, positions: FloatArray, torques: FloatArray) -> FloatArray:
    """(T, m) where joints are that shall be at (T, m) [rad].

    Args:
        robot: its sag, play and torque limits.
        positions: commanded joint angles.
        torques: (T, k) of the leg motors, that hold the posture [N m].
    """
    used = torques / robot.effort_limit[robot.legs]
    give = robot.deflection
    change = -give.sag * used - 0.5 * give.play * np.tanh(used / _CROSSING)
    moved: FloatArray = positions + robot.from_legs(change, np.zeros(positions.shape[1]))
    return moved


def sag_of_foot(
    robot: Robot, meant: FootPose, true: FootPose, support_phase: SupportPhase
) -> tuple[float, float]:
    """How much lower, and how much nearer to the other foot, one in the air is than meant [m].

    Args:
        robot: whose feet.
        meant, true: pose between the feet as commanded, and with deflected joints.
        support_phase: the foot that stands.
    """
    drop = _lowest_corner(robot, meant, support_phase) - _lowest_corner(robot, true, support_phase)
    return drop, feet_gap(robot, meant.support) - feet_gap(robot, true.support)


def _lowest_corner(robot: Robot, pose: FootPose, support_phase: SupportPhase) -> float:
    """Height of the lowest corner of the foot in the air over the floor of the other [m]."""
    seen = pose.inverse if support_phase is SupportPhase.RIGHT else pose
    outline = robot.feet[1 - support_phase.standing].outline
    corners = np.column_stack([outline, np.zeros(len(outline))])
    return float((corners @ seen.rotation.T + seen.translation)[:, 2].min())
