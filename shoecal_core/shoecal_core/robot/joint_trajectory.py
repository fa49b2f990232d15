"""Joint trajectories as a robot is commanded to follow them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError, ShapeError, ShoecalError

if TYPE_CHECKING:  # who reads or sends a trajectory needs neither
    from scipy.interpolate import CubicHermiteSpline

    from shoecal_core.robot.robot import Robot

_SLACK = 1e-6
"""rad; joint limits may be missed by rounding, and two angles of one motor may differ by it."""


@dataclass(frozen=True)
class JointTrajectory:
    """Points that named joints pass.

    Attributes:
        names: joints, k of them; joints not named stay where they are.
        times: (T,) since the start of the motion, increasing from 0 or later [s].
        positions: (T, k) [rad].
        velocities: (T, k) [rad/s]; None: from rest to rest, whatever speeds lie between.
    """

    names: tuple[str, ...]
    times: FloatArray
    positions: FloatArray
    velocities: FloatArray | None = None

    def __post_init__(self) -> None:
        if not self.names:
            raise ShoecalError("the trajectory names no joint; correct its sender")
        if self.times.ndim != 1 or not len(self.times):
            raise ShapeError("trajectory times", "(T,), T > 0", self.times.shape)
        expected = (len(self.times), len(self.names))
        if self.positions.shape != expected:
            raise ShapeError("trajectory positions", str(expected), self.positions.shape)
        if self.velocities is not None and self.velocities.shape != expected:
            raise ShapeError("trajectory velocities", str(expected), self.velocities.shape)
        numbers = (self.times, self.positions, self.velocities)
        if not all(np.isfinite(one).all() for one in numbers if one is not None):
            raise ShoecalError("the trajectory holds numbers that are not finite; plan it again")
        if self.times[0] < 0.0 or np.any(np.diff(self.times) <= 0.0):
            raise ShoecalError("the trajectory's times must increase from 0 s or later")

    @property
    def duration(self) -> float:
        """Time of the last point [s]."""
        return float(self.times[-1])

    def full(self, robot: Robot, start: FloatArray) -> JointTrajectory:
        """The same for all joints of a robot.

        Args:
            robot: that will follow it.
            start: (m,) where its joints are commanded to be at time 0 [rad].

        Raises:
            NameNotFoundError: for a joint that the robot does not have.
            ShoecalError: for positions beyond a joint's limits, or two for one motor.
        """
        for name in self.names:
            if name not in robot.joint_names:
                raise NameNotFoundError("joint", name, robot.joint_names)
        positions = np.tile(start, (len(self.times), 1))
        columns = [robot.joint(name) for name in self.names]
        positions[:, columns] = self.positions
        velocities = None
        if self.velocities is not None:
            velocities = np.zeros_like(positions)
            velocities[:, columns] = self.velocities
        _check_limits(robot, positions, columns)
        for shared in robot.shared:
            given = positions[:, shared.joint].copy()
            if shared.joint in columns and shared.leader not in columns:
                positions[:, shared.leader] = given / shared.ratio
            positions[:, shared.joint] = shared.ratio * positions[:, shared.leader]
            if shared.joint in columns and np.any(abs(positions[:, shared.joint] - given) > _SLACK):
                raise ShoecalError(
                    f"joints '{robot.joint_names[shared.joint]}' and "
                    f"'{robot.joint_names[shared.leader]}' are one motor, yet the trajectory moves "
                    "them differently; send one of them"
                )
            if velocities is not None:
                leader = shared.leader if shared.leader in columns else shared.joint
                ratio = 1.0 if leader == shared.leader else shared.ratio
                velocities[:, shared.leader] = velocities[:, leader] / ratio
                velocities[:, shared.joint] = shared.ratio * velocities[:, shared.leader]
        whole = JointTrajectory(robot.joint_names, self.times, positions, velocities)
        return whole.begun_at(start)

    def begun_at(self, start: FloatArray) -> JointTrajectory:
        """The same with a point at time 0: where it has none, joints rest at (k,) [rad] then."""
        if self.times[0] == 0.0:
            return self
        velocities = self.velocities
        if velocities is not None:
            velocities = np.vstack((np.zeros_like(start), velocities))
        return JointTrajectory(
            self.names,
            np.concatenate(([0.0], self.times)),
            np.vstack((start, self.positions)),
            velocities,
        )

    def at(self, times: FloatArray) -> FloatArray:
        """(..., k) positions [rad] at times (...) [s]; held before the start and after the end."""
        if len(self.times) == 1:
            return np.broadcast_to(self.positions[0], (*np.shape(times), len(self.names)))
        positions: FloatArray = self._curve(np.clip(times, self.times[0], self.times[-1]))
        return positions

    def rates(self, times: FloatArray) -> FloatArray:
        """(..., k) velocities [rad/s] at times (...) [s]; zero before the start, after the end."""
        if len(self.times) == 1:
            return np.zeros((*np.shape(times), len(self.names)))
        within = (self.times[0] <= times) & (times <= self.times[-1])
        rates: FloatArray = self._curve(np.clip(times, self.times[0], self.times[-1]), nu=1)
        rates *= np.asarray(within)[..., None]
        return rates

    def peaks(self) -> tuple[FloatArray, FloatArray]:
        """(k,) largest speed [rad/s] and acceleration [rad/s^2] of each joint, between the points.

        Those of the cubic through them, which is what `at` gives.
        """
        if len(self.times) == 1:
            return np.zeros(len(self.names)), np.zeros(len(self.names))
        cubic, square, slope = self._curve.c[:3]
        length = np.diff(self.times)[:, None]
        # Acceleration is even along a piece, so its largest is at an end, and speed has its own
        # where acceleration passes zero, or at an end.
        accelerations = np.abs((2.0 * square, 6.0 * cubic * length + 2.0 * square)).max(axis=0)
        turn = np.divide(-square, 3.0 * cubic, out=np.zeros_like(square), where=cubic != 0.0)
        places = np.stack((np.zeros_like(turn), length + 0.0 * turn, np.clip(turn, 0.0, length)))
        speeds = np.abs(slope + places * (2.0 * square + places * 3.0 * cubic)).max(axis=0)
        return speeds.max(axis=0), accelerations.max(axis=0)

    @cached_property
    def _curve(self) -> CubicHermiteSpline:
        # Nodes that pass trajectories on never come here, and start in half the time without.
        from scipy.interpolate import CubicHermiteSpline, PchipInterpolator  # noqa: PLC0415

        # Monotone between points: no joint swings beyond what was planned.
        if self.velocities is not None:
            slopes = self.velocities
        elif len(self.times) == 2:
            slopes = np.zeros_like(self.positions)
        else:
            slopes = PchipInterpolator(self.times, self.positions)(self.times, nu=1)
            slopes[[0, -1]] = 0.0
        return CubicHermiteSpline(self.times, self.positions, slopes)


def _check_limits(robot: Robot, positions: FloatArray, columns: list[int]) -> None:
    for joint in columns:
        lowest, highest = positions[:, joint].min(), positions[:, joint].max()
        if lowest < robot.lower[joint] - _SLACK or highest > robot.upper[joint] + _SLACK:
            raise ShoecalError(
                f"joint '{robot.joint_names[joint]}' is commanded to move {lowest:.4g} to "
                f"{highest:.4g} rad, beyond its limits {robot.lower[joint]:.4g} to "
                f"{robot.upper[joint]:.4g} rad; plan the motion again"
            )
