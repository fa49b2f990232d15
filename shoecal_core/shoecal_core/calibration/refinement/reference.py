"""How unknowns of the body move the CoP that the model expects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.refinement.unknowns import ALL, Unknown
from shoecal_core.errors import NameNotFoundError
from shoecal_core.model.robot import GRAVITY, Robot
from shoecal_core.model.sensitivity import BodySensitivity, SensitiveBody
from shoecal_core.samples.stance import Stance

FloatArray = NDArray[np.float64]

SIGN_NM = 0.15
"""Torque at which a gear lies firmly on one side of its play: friction hides smaller ones."""


class Reference:
    """The modelled CoP of one robot, and what moves it."""

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.body = SensitiveBody(robot)

    def shifts(self, stance: Stance, unknowns: Sequence[Unknown]) -> FloatArray:
        """(T, 2, k) of the CoP in the stance's frame, a unit of each unknown.

        Everything here changes slowly, so few samples will do.

        Args:
            stance: with joint angles, and efforts where gears are among the unknowns.

        Raises:
            NameNotFoundError: for a joint or link that the robot does not have.
        """
        assert stance.angles is not None
        body = self.body.at(stance.angles, stance.loaded.index(True))
        columns = [self._shift(one, stance, body) for one in unknowns]
        return np.stack(columns, axis=2) if columns else np.zeros((len(stance.time), 2, 0))

    def _shift(self, unknown: Unknown, stance: Stance, body: BodySensitivity) -> FloatArray:
        kind = unknown.effect
        if kind in {"link_com", "payload"}:
            link = self._link(unknown)
            if kind == "link_com":
                return body.cop_by_com[:, :, link, "xyz".index(unknown.component)]
            mass = float(self.robot.model.inertias[self._carrier(link)].mass)
            return body.cop_by_mass[:, :, link] / mass
        # What an encoder tells too much, the link has not.
        by_joint = -body.cop_by_joint
        joints = self._joints(unknown)
        if kind == "joint_offset":
            return np.asarray((by_joint[:, :, joints[0]] * joints[1]).sum(axis=2))
        assert stance.efforts is not None
        torque = stance.efforts[:, joints[0]]
        give = torque if kind == "joint_compliance" else 0.5 * np.tanh(torque / SIGN_NM)
        return np.asarray((by_joint[:, :, joints[0]] * give[:, None]).sum(axis=2))

    def _joints(self, unknown: Unknown) -> tuple[list[int], FloatArray]:
        """Indices of the joints that are meant, and how far each goes with the first's motor."""
        robot = self.robot
        if unknown.location == (ALL,):
            moved = robot.moved.tolist()
            return moved, np.ones(len(moved))
        first = robot.joint(unknown.location[0])
        shared = [one for one in robot.shared if one.leader == first]
        return [first, *(one.joint for one in shared)], np.array(
            [1.0, *(one.ratio for one in shared)]
        )

    def _link(self, unknown: Unknown) -> int:
        """Place among the links with a mass, by the name of the link or of its joint."""
        name, links = unknown.location[0], self.body.links
        if name in links:
            return links.index(name)
        for frame in self.robot.model.frames:
            if frame.name == name:
                carrier = str(self.robot.model.names[frame.parentJoint])
                if carrier in links:
                    return links.index(carrier)
        if name == "base":
            return 0
        raise NameNotFoundError("link", name, links)

    def _carrier(self, link: int) -> int:
        return int(self.robot.model.getJointId(self.body.links[link]))


def extra_force(unknown: Unknown) -> float:
    """By how much the robot is heavier for one unit of an unknown [N]."""
    return GRAVITY if unknown.effect == "payload" else 0.0
