"""What a calibration states of its errors at any readings: in reports and live alike.

The wrenches of both feet are linear in the readings, w = E (S, 1) with

    E_i = c_i A_i        of channel i        E_0 = sum_i d_i A_i + weight below the channels

and so are their errors, by those of gains c, offsets d and columns A. With P the covariance of all
three, each element of cov(w) is a quadratic form of (S, 1): all that it needs is computed once.

Three terms no fit of gains knows: the weight that the GRF rests on, which scales all gains alike;
sideways forces at the cells' height, which move the CoP of each foot and not that of both; and
where the right foot stands, which moves that of both alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.drift import shares_model
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, cop_jacobian, to_left, weight_below

LEFT, RIGHT = 0, 1
FRAMES = (slice(0, 3), slice(3, 6))
"""Of the six numbers of both feet, those of each."""
Turns = tuple[FloatArray, FloatArray]
"""(3, 3) each: take F, Mx, My of the left and of the right foot into one sole's frame."""


@dataclass(frozen=True)
class StatedWrench:
    """A measured wrench and its errors, for any leading shape.

    Attributes:
        wrench: (..., 3) F [N], Mx, My [N m].
        covariance: (..., 3, 3) of its errors; NaN where a reading is.
    """

    wrench: FloatArray
    covariance: FloatArray

    @property
    def output_covariance(self) -> FloatArray:
        """(..., 3, 3) of the force and the CoP x and y, to first order; NaN without a load."""
        loaded = self.wrench[..., :1] > MINIMUM_FORCE
        slopes = cop_jacobian(np.where(loaded, self.wrench, np.nan))
        found: FloatArray = slopes @ self.covariance @ np.swapaxes(slopes, -1, -2)
        return found


@dataclass(frozen=True)
class StatedError:
    """Errors that are stated of a calibration of n channels.

    Attributes:
        shoe: with the columns that are used for measuring.
        parameters: gains and offsets.
        covariance: (5n, 5n) of the errors of gains, offsets and columns, channel by channel.
        weight_share: standard deviation of the weight, as a share of it.
        unfelt: standard deviation of the moments about x and y that each foot does not feel [N m].
        support_covariance: (3, 3) mean square errors of the right foot's dx, dy, dtheta.
    """

    shoe: Shoe
    parameters: ChannelParameters
    covariance: FloatArray
    weight_share: float
    unfelt: tuple[float, float]
    support_covariance: FloatArray

    @classmethod
    def of(
        cls,
        robot: Robot,
        shoe: Shoe,
        parameters: ChannelParameters,
        covariance: FloatArray,
        support_covariance: FloatArray,
        sideways: float,
    ) -> StatedError:
        """On a robot.

        Args:
            robot: whose weight counts.
            shoe, parameters: as the attributes.
            covariance: (5n, 5n) likewise.
            support_covariance: (3, 3) likewise.
            sideways: standard deviation of the sideways force on a foot, each axis [N].
        """
        unfelt = (sideways_moment(shoe, LEFT, sideways), sideways_moment(shoe, RIGHT, sideways))
        share = robot.mass_std * GRAVITY / robot.weight
        return cls(shoe, parameters, covariance, share, unfelt, support_covariance)

    @classmethod
    def of_calibration(
        cls, calibration: Calibration, robot: Robot, shoe: Shoe, tolerances: Tolerances
    ) -> StatedError | None:
        """Of a calibration as it is filed; None where it has no covariance.

        The weight counts where gains were fitted to it; known weights do not ask for the robot's.

        Args:
            calibration: of this shoe.
            robot: on it.
            shoe: as its file says.
            tolerances: of both.
        """
        covariance, support = calibration.joint_covariance, calibration.support_covariance
        if covariance is None:
            return None
        found = cls.of(
            robot,
            calibration.calibrated(shoe),
            calibration.parameters,
            covariance,
            placement_covariance(tolerances) if support is None else support,
            tolerances.sideways_share * robot.weight,
        )
        return found if shares_model(calibration) else replace(found, weight_share=0.0)

    def at(self, readings: FloatArray, noise: FloatArray | None = None) -> StatedSample:
        """At readings.

        Args:
            readings: (..., n) raw; of a foot with one that is NaN nothing is known.
            noise: (n,) standard deviations of the readings' own noise; None: it does not count.
        """
        bad = np.isnan(readings)
        lost = bad.any()
        known = np.ones((*readings.shape[:-1], readings.shape[-1] + 1))
        known[..., :-1] = np.where(bad, 0.0, readings) if lost else readings
        wrench = known @ self._map
        squares = known[..., :, None] * known[..., None, :]
        leading = readings.shape[:-1]
        found = (squares.reshape(*leading, -1) @ self._moments).reshape(*leading, 6, 6)
        scaled = self.weight_share * wrench
        found += scaled[..., :, None] * scaled[..., None, :]
        if noise is not None:
            noisy = self._map[:-1].T * noise
            found += noisy @ noisy.T
        if lost:
            unknown = bad @ (self._map[:-1] != 0.0)
            found[unknown] = np.nan
            np.swapaxes(found, -1, -2)[unknown] = np.nan
        return StatedSample(self, wrench, found)

    @cached_property
    def unfelt_covariance(self) -> FloatArray:
        """(2, 3, 3) of each foot's wrench, by sideways forces."""
        return np.array([np.diag([0.0, one**2, one**2]) for one in self.unfelt])

    @cached_property
    def _map(self) -> FloatArray:
        """(n + 1, 6) E: the wrenches of both feet by the readings and one."""
        count, law = len(self.shoe.names), self.parameters
        found = np.zeros((count + 1, 6))
        found[-1] = weight_below(self.shoe).ravel()
        for foot, part in enumerate(FRAMES):
            own = self.shoe.of_foot(foot)
            found[own, part] = law.gain[own, None] * self.shoe.columns[own]
            found[-1, part] += law.offset[own] @ self.shoe.columns[own]
        return found

    @cached_property
    def _moments(self) -> FloatArray:
        """((n + 1)^2, 36) of the covariance of both feet's wrenches by products of (S, 1)."""
        count, law, columns = len(self.shoe.names), self.parameters, self.shoe.columns
        change = np.zeros((6, count + 1, 5 * count))
        for channel, foot in enumerate(self.shoe.foot):
            rows = np.arange(3 * foot, 3 * foot + 3)
            own = 2 * count + 3 * channel + np.arange(3)
            change[rows, channel, channel] = columns[channel]
            change[rows, -1, count + channel] = columns[channel]
            change[rows, channel, own] = law.gain[channel]
            change[rows, -1, own] = law.offset[channel]
        flat = change.reshape(-1, 5 * count)
        spread = (flat @ self.covariance @ flat.T).reshape(6, count + 1, 6, count + 1)
        return np.ascontiguousarray(spread.transpose(1, 3, 0, 2).reshape((count + 1) ** 2, 36))


@dataclass(frozen=True)
class StatedSample:
    """What is stated at some readings, for any leading shape.

    Attributes:
        stated: of the calibration.
        wrench: (..., 6) F, Mx, My of the left, then of the right foot, in its own sole's frame.
        covariance: (..., 6, 6) by gains, offsets, columns and the weight, and the readings' noise.
    """

    stated: StatedError
    wrench: FloatArray
    covariance: FloatArray

    def foot(self, foot: int) -> StatedWrench:
        """One foot in its own sole's frame."""
        part = FRAMES[foot]
        own = self.covariance[..., part, part] + self.stated.unfelt_covariance[foot]
        return StatedWrench(self.wrench[..., part], own)

    def both(self, turns: Turns, target: int = LEFT) -> StatedWrench:
        """Both feet together.

        Args:
            turns: into the target's frame, as `turns_to`.
            target: foot in whose sole frame it is wanted.
        """
        across = np.hstack(turns)
        covariance = across @ self.covariance @ across.T
        # The other foot's wrench in the right sole's frame, turned as the left one lies.
        other = self.wrench[..., FRAMES[1 - target]]
        turn = turns[1 - target]
        rotation = turn[1:, 1:]
        if target == RIGHT:
            other = other @ turn.T
            rotation = rotation.T
        force, about = other[..., 0], other[..., 1:] @ rotation.T
        by_pose = np.zeros((*other.shape[:-1], 3, 3))
        by_pose[..., 2, 0], by_pose[..., 1, 1] = -force, force
        by_pose[..., 1, 2], by_pose[..., 2, 2] = -about[..., 1], about[..., 0]
        slopes = turns[LEFT] @ by_pose
        covariance += slopes @ self.stated.support_covariance @ np.swapaxes(slopes, -1, -2)
        return StatedWrench(self.wrench @ across.T, covariance)


def turns_to(support: DoubleSupport, target: int = LEFT) -> Turns:
    """Into one sole's frame, both soles on one floor.

    Args:
        support: where the right foot stands.
        target: LEFT 0 or RIGHT 1.
    """
    turn: FloatArray = to_left(support)
    if target == RIGHT:
        return np.asarray(np.linalg.inv(turn), dtype=np.float64), np.eye(3)
    return np.eye(3), turn


def placement_covariance(tolerances: Tolerances) -> FloatArray:
    """(3, 3) of the right foot's dx, dy, dtheta in each run, beyond what the joints explain."""
    return np.diag(np.square([tolerances.support_m, tolerances.support_m, tolerances.support_rad]))


def sideways_moment(shoe: Shoe, foot: int, sideways: float) -> float:
    """Standard deviation of the moment about x and y that a foot's cells do not feel [N m].

    Args:
        shoe: with its channels.
        foot: LEFT 0 or RIGHT 1; sensors that measure torques feel it: 0.
        sideways: standard deviation of the sideways force on a foot, each axis [N].
    """
    felt = bool(shoe.torque[shoe.of_foot(foot)].any())
    return 0.0 if felt else 0.5 * shoe.height * sideways
