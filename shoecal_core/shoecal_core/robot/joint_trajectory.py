"""Joint trajectories as a robot is commanded to follow them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import NameNotFoundError, ShapeError, ShoecalError
from shoecal_core.robot.robot import Robot

if TYPE_CHECKING:
    from scipy.interpolate import CubicHermiteSpline

FloatArray = NDArray[np.float64]

_SLACK = 1e-6
"""rad; joint limits may be missed by rounding, and two angles of one motor may differ by it."""


@dataclass(frozen=True)
class JointTrajectory:
    """Points that named joints pass, from rest to rest.

    Attributes:
        names: joints, k of them; joints not named stay where they are.
        times: (T,) since the start of the motion, increasing from 0 or later [s].
        positions: (T, k) [rad].
    """

    names: tuple[str, ...]
    times: FloatArray
    positions: FloatArray

    def __post_init__(self) -> None:
        if not self.names:
            raise ShoecalError("the trajectory names no joint; correct its sender")
        if self.times.ndim != 1 or not len(self.times):
            raise ShapeError("trajectory times", "(T,), T > 0", self.times.shape)
        expected = (len(self.times), len(self.names))
        if self.positions.shape != expected:
            raise ShapeError("trajectory positions", str(expected), self.positions.shape)
        if not (np.isfinite(self.times).all() and np.isfinite(self.positions).all()):
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
        times = self.times
        if times[0] > 0.0:
            times = np.concatenate(([0.0], times))
            positions = np.vstack((start, positions))
        return JointTrajectory(robot.joint_names, times, positions)

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
        # At both ends they are zero, as they are beyond.
        rates: FloatArray = self._curve(np.clip(times, self.times[0], self.times[-1]), nu=1)
        return rates

    @cached_property
    def _curve(self) -> CubicHermiteSpline:
        # Nodes that pass trajectories on never come here, and start in half the time without.
        from scipy.interpolate import CubicHermiteSpline, PchipInterpolator  # noqa: PLC0415

        # Monotone between points: no joint swings beyond what was planned.
        if len(self.times) == 2:
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
