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

from collections.abc import Sequence

import mujoco
import numpy as np

from shoecal_core.arrays import FloatArray

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


class BristleFriction:
    """Lets bristles slip, step by step of the physics.

    Attributes:
        acts: whether any joint has friction.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        joints: Sequence[str],
        friction: FloatArray,
        stribeck_speed: float,
    ) -> None:
        """Of a robot.

        Args:
            model: with the bristles.
            joints: names of m joints.
            friction: (m, 2) of each: static, kinetic [N m]; none where static is zero.
            stribeck_speed: at which most of the fall from the one to the other is done [rad/s].
        """
        rubbing = np.flatnonzero(friction[:, 0])
        self.acts = rubbing.size > 0
        self._model, self._speed = model, stribeck_speed
        self._bristles = np.array(
            [model.tendon(_name(joints[index])).id for index in rubbing.tolist()], dtype=np.int64
        )
        # Tendons' lengths belong to the last step's start, which is a step too old here.
        self._turn = np.zeros((len(rubbing), model.nq))
        self._rate = np.zeros((len(rubbing), model.nv))
        for row, bristle in enumerate(self._bristles):
            first, count = model.tendon_adr[bristle], model.tendon_num[bristle]
            spanned = model.wrap_objid[first : first + count]
            self._turn[row, model.jnt_qposadr[spanned]] = 1.0
            self._rate[row, model.jnt_dofadr[spanned]] = 1.0
        # An integrator that is implicit in stiffness balances springs as a step ends.
        discrete = model.opt.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE
        self._ahead = model.opt.timestep if discrete else 0.0
        # How far a bristle is bent when it slips [rad]: at rest, and at speed.
        static, kinetic = friction[rubbing].T
        self._at_rest = np.full(len(rubbing), _BENT)
        self._at_speed = _BENT * np.minimum(kinetic / static, 1.0)

    def release(self, data: mujoco.MjData) -> None:
        """Let all bristles stand straight where the joints are."""
        self._anchor(self._turn @ data.qpos)

    def slip(self, data: mujoco.MjData) -> None:
        """Move the anchors of those that will pull too much, before a step of the physics."""
        speed = self._rate @ data.qvel
        length = self._turn @ data.qpos + self._ahead * speed
        slow = np.exp(-((speed / self._speed) ** 2))
        longest = self._at_speed + (self._at_rest - self._at_speed) * slow
        anchor = self._model.tendon_lengthspring[self._bristles, 0]
        self._anchor(np.clip(anchor, length - longest, length + longest))

    def _anchor(self, places: FloatArray) -> None:
        self._model.tendon_lengthspring[self._bristles] = places[:, None]


def _name(joint: str) -> str:
    return f"bristle/{joint}"
