"""Friction of the joints' bearings and teeth, on the links' side of what gives.

Motors hold against it through their gears, so a link sags less or more by compliance times
friction, depending on which way its joint came last: encoders do not see it.

Each joint has a bristle: a spring between the two links whose anchor slips as soon as it pulls
more than the friction of the moment (Jenkins' element), which falls with the joint's speed v from
static to kinetic (Stribeck):

    F(v) = F_k + (F_s - F_k) exp(-(v / v_s)^2)

At rest a bristle keeps its pull: friction does not let go with time.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from shoecal_core.simulation.drawn import DrawnBody

FloatArray = NDArray[np.float64]

_BENT = 1e-3
"""rad; by which a bristle is bent when static friction gives way."""


def add_bristle(
    spec: mujoco.MjSpec, motor: mujoco.MjsJoint, static: float, gear: str | None
) -> None:
    """Add one joint's bristle.

    Args:
        spec: the world.
        motor: the joint's motor side.
        static: friction at rest [N m].
        gear: joint of its gear, which the bristle spans too; None where it does not give.
    """
    bristle = spec.add_tendon(
        name=_name(motor.name), stiffness=[static / _BENT, 0.0, 0.0], springlength=[0.0, 0.0]
    )
    for joint in filter(None, (motor.name, gear)):
        bristle.wrap_joint(joint, 1.0)


class JointFriction:
    """Lets bristles slip, step by step of the physics.

    Attributes:
        acts: whether any joint has friction.
    """

    def __init__(self, model: mujoco.MjModel, body: DrawnBody, stribeck_speed: float) -> None:
        """Of a robot.

        Args:
            model: with the bristles.
            body: as it truly is.
            stribeck_speed: at which most of the fall from static to kinetic is done [rad/s].
        """
        with_friction = np.flatnonzero(body.friction[:, 0])
        self.acts = with_friction.size > 0
        self._model, self._speed = model, stribeck_speed
        self._bristles = np.array(
            [model.tendon(_name(body.joints[joint])).id for joint in with_friction], dtype=np.int64
        )
        # How far a bristle is bent when it slips [rad]: at rest, and at speed.
        static, kinetic = body.friction[with_friction].T
        self._at_rest = np.full(len(with_friction), _BENT)
        self._at_speed = _BENT * np.minimum(kinetic / static, 1.0)

    def release(self, data: mujoco.MjData) -> None:
        """Let all bristles stand straight where the joints are."""
        mujoco.mj_tendon(self._model, data)
        self._anchor(data.ten_length[self._bristles])

    def slip(self, data: mujoco.MjData) -> None:
        """Move the anchors of those that pull too much, after a step of the physics."""
        length, speed = data.ten_length[self._bristles], data.ten_velocity[self._bristles]
        slow = np.exp(-((speed / self._speed) ** 2))
        longest = self._at_speed + (self._at_rest - self._at_speed) * slow
        anchor = self._model.tendon_lengthspring[self._bristles, 0]
        self._anchor(np.clip(anchor, length - longest, length + longest))

    def _anchor(self, places: FloatArray) -> None:
        self._model.tendon_lengthspring[self._bristles] = places[:, None]


def _name(joint: str) -> str:
    return f"bristle/{joint}"
