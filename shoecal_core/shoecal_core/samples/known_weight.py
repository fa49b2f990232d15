"""A run with a known weight on the torso: only it separates the robot's mass from a common gain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.robot.robot import Robot

WEIGHTED = "known_weight"
"""Name that a recording gives the motion of such a run."""
KNOWN_MASS = 0.5
"""Fastened at the origin of the root link's frame, in the middle of the torso [kg]."""


def carried(motion: str) -> float:
    """Known mass on the robot in a run [kg]."""
    return KNOWN_MASS if motion == WEIGHTED else 0.0


def with_mass(states: BodyStates, robot: Robot, mass: FloatArray | float) -> BodyStates:
    """The body with known masses, a number or (T,), at the origin of its base [kg]."""
    masses = np.broadcast_to(mass, len(states.com))[:, None, None]
    in_left = -np.einsum("tji,tj->ti", states.left_rotation, states.left_translation)
    in_right = np.einsum("tji,tj->ti", states.rotation, in_left - states.translation)
    place = np.stack((in_left, in_right), axis=1)
    share = masses / (robot.mass + masses)
    return replace(states, com=states.com + share * (place - states.com))
