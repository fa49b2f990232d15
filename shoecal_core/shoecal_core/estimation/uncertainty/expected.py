"""How far calibrated GRF and CoP of a fit may be off the truth, load by load.

Stated errors are those of `stated_error`, for the posterior covariance of gains, offsets and the
deviations of the shoe; the derivatives by all of these say where they come from.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ellipe

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.body import driven_together
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.joint_fit import JointFit
from shoecal_core.estimation.uncertainty.stated_error import (
    LEFT,
    RIGHT,
    StatedError,
    StatedWrench,
    placement_covariance,
    turns_to,
)
from shoecal_core.planning.landmarks import sensing_hull
from shoecal_core.planning.supports.places import places_over
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.load_cases import double_support_outputs, single_support_outputs
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import (
    ChannelParameters,
    by_parameters,
    columns_in_left,
    combined,
    cop,
    cop_jacobian,
    foot_wrenches,
    to_left,
)


@dataclass(frozen=True)
class Spread:
    """Standard deviations of a wrench's error at p load cases.

    Attributes:
        places: (p, 2) the CoP, in the frame that it is given in [m].
        grf: (p,) [N].
        cop: (p, 2) along x and y [m]; NaN where nothing is loaded.
    """

    places: FloatArray
    grf: FloatArray
    cop: FloatArray

    @property
    def cop_mean(self) -> FloatArray:
        """(p,) expected length of the CoP's error, as its mean absolute error has it [m].

        Of a normal error with standard deviations a >= b along its axes it is
        a sqrt(2 / pi) E(1 - b^2 / a^2), E the complete elliptic integral of the second kind.
        """
        long, short = self.cop.max(axis=1), self.cop.min(axis=1)
        ratio = np.divide(short, long, out=np.ones_like(long), where=long > 0.0)
        mean: FloatArray = long * np.sqrt(2.0 / np.pi) * ellipe(1.0 - ratio**2)
        return mean

    @property
    def cop_mae(self) -> float:
        """Mean of that over the load cases with a load [m]."""
        return float(np.nanmean(self.cop_mean))

    @property
    def grf_rms(self) -> float:
        """Root mean square of the GRF's [N]."""
        return float(np.sqrt(np.nanmean(self.grf**2)))

    @property
    def cop_rms(self) -> float:
        """Root mean square length of the CoP's error over the load cases with a load [m]."""
        return float(np.sqrt(np.nanmean(self.cop_length**2)))

    @property
    def cop_length(self) -> FloatArray:
        """(p,) root mean square length of the CoP's error [m]."""
        length: FloatArray = np.linalg.norm(self.cop, axis=1)
        return length

    def at_least(self, grf: float, cop: float) -> Spread:
        """Scaled up to these root mean squares [N, m] where it is below."""
        more_grf = max(1.0, grf / self.grf_rms)
        more_cop = max(1.0, cop / self.cop_rms)
        return Spread(self.places, more_grf * self.grf, more_cop * self.cop)


PLANAR = (0, 1, 5)
"""Of the six numbers of the right sole's pose in the left's: dx, dy, dtheta."""


def support_covariance(joint: JointFit | None, tolerances: Tolerances) -> FloatArray:
    """(3, 3) mean square of the errors of dx, dy, dtheta in any double support [m, m, rad].

    What each run has by itself, and the joints' zeros: a support is formed from joints as they
    read, so what was found of their zeros moves it as much as what is still uncertain of them.
    """
    own = placement_covariance(tolerances)
    if joint is None:
        return own
    signal_model = joint.signal_model
    zeros = [
        (index, one)
        for index, one in enumerate(joint.deviations, start=len(joint.vector))
        if one.deviation.effect == "joint_offset"
    ]
    if not zeros or not signal_model.samples.both.any():
        return own
    robot = signal_model.samples.robot
    mean = signal_model.jacobians.closure[signal_model.samples.both][:, PLANAR].mean(axis=0)
    slopes = np.zeros((3, len(zeros)))
    for column, (_, one) in enumerate(zeros):
        for moved, ratio in driven_together(robot, robot.joint(one.deviation.location[0])):
            slopes[:, column] += ratio * mean[:, moved]
    indices = np.array([index for index, _ in zeros])
    found = np.array([one.value for _, one in zeros])
    mean_square = joint.covariance[np.ix_(indices, indices)] + np.outer(found, found)
    covariance: FloatArray = own + slopes @ mean_square @ slopes.T
    return covariance


@dataclass(frozen=True)
class ErrorModel:
    """Expected errors of one calibration.

    Attributes:
        robot: whose weight and sensing polygons count.
        shoe: with the columns that are used for measuring.
        filed: the same as its file has it, by which channels share a load.
        parameters: gains and offsets.
        covariance: (p, p) of the errors of gains, offsets and shoe deviations, p = 2n + d.
        shoe_columns: (d, n, 3) what one unit of each shoe deviation adds to the columns.
        support_covariance: (3, 3) mean square errors of the right foot's dx, dy, dtheta.
        sideways: standard deviation of the sideways force on a foot, each axis [N].
    """

    robot: Robot
    shoe: Shoe
    filed: Shoe
    parameters: ChannelParameters
    covariance: FloatArray
    shoe_columns: FloatArray
    support_covariance: FloatArray
    sideways: float

    @classmethod
    def of(
        cls,
        robot: Robot,
        shoe: Shoe,
        filed: Shoe,
        parameters: ChannelParameters,
        covariance: FloatArray,
        shoe_columns: Sequence[FloatArray],
        support_covariance: FloatArray,
        tolerances: Tolerances,
    ) -> ErrorModel:
        """With the tolerances of a robot; arrays as the attributes, a column (n, 3) a deviation."""
        count = len(shoe.names)
        return cls(
            robot,
            shoe,
            filed,
            parameters,
            covariance,
            np.array(shoe_columns).reshape(-1, count, 3),
            support_covariance,
            tolerances.sideways_share * robot.weight,
        )

    @cached_property
    def stated(self) -> StatedError:
        """The same without the names of the deviations, as a calibration file holds it."""
        own = 2 * len(self.shoe.names)
        turn = np.zeros((own + self.shoe.columns.size, len(self.covariance)))
        turn[:own, :own] = np.eye(own)
        turn[own:, own:] = self.shoe_columns.reshape(-1, self.shoe.columns.size).T
        covariance = turn @ self.covariance @ turn.T
        return StatedError.of(
            self.robot,
            self.shoe,
            self.parameters,
            covariance,
            self.support_covariance,
            self.sideways,
        )

    def both_feet(self, outputs: FloatArray, support: DoubleSupport) -> Spread:
        """Of both feet together in the left sole's frame, for outputs (p, n) [N or N m]."""
        return _of_both(self.stated, outputs, support)

    def foot(self, outputs: FloatArray, foot: int) -> Spread:
        """Of one foot in its own sole's frame, for outputs (p, n) of all channels [N or N m]."""
        return _of_foot(self.stated, outputs, foot)

    def both_jacobian(self, outputs: FloatArray, support: DoubleSupport) -> FloatArray:
        """(p, 3, 2n + d) of GRF and CoP of both feet by gains, offsets and shoe deviations."""
        wrenches = combined(foot_wrenches(self.shoe, outputs), support)
        right = (self.shoe.foot == 1)[:, None]
        changes = np.where(right, self.shoe_columns @ to_left(support).T, self.shoe_columns)
        return self._jacobian(columns_in_left(self.shoe, support), changes, wrenches, outputs)

    def foot_jacobian(self, outputs: FloatArray, foot: int) -> FloatArray:
        """(p, 3, 2n + d) of GRF and CoP of one foot."""
        own = (self.shoe.foot == foot)[:, None]
        wrenches = foot_wrenches(self.shoe, outputs)[:, foot]
        columns = np.where(own, self.shoe.columns, 0.0)
        return self._jacobian(columns, np.where(own, self.shoe_columns, 0.0), wrenches, outputs)

    def load_cases(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """(p, n) outputs, as `load_cases`."""
        return load_cases(self.robot, self.filed)

    def over_polygons(self) -> tuple[Spread, Spread, Spread]:
        """Of both feet, left and right in their load cases."""
        return over_polygons(self.stated, self.robot, self.filed)

    def _jacobian(
        self, columns: FloatArray, changes: FloatArray, wrenches: FloatArray, outputs: FloatArray
    ) -> FloatArray:
        loaded = wrenches[:, :1] > MINIMUM_FORCE
        wrenches = np.where(loaded, wrenches, [1.0, 0.0, 0.0])
        by_wrench = cop_jacobian(wrenches)
        readings = self.parameters.readings(outputs)
        by_shoe = by_wrench @ np.einsum("pn,dnk->pkd", outputs, changes)
        return np.concatenate((by_parameters(by_wrench @ columns.T, readings), by_shoe), axis=2)


def load_cases(robot: Robot, filed: Shoe) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Outputs (p, n) of both feet in the neutral double support with the CoP anywhere in the
    hull of both sensing polygons, and of left and right under half the weight with the CoP
    anywhere in the foot's own polygon [N or N m].

    Args:
        robot: whose weight and polygons count.
        filed: the shoe as its file has it, by which channels share a load.
    """
    support = robot.neutral
    places = places_over(np.array(sensing_hull(robot, support).exterior.coords))
    both = double_support_outputs(filed, support, robot.weight, places)
    left, right = (
        single_support_outputs(filed, index, robot.weight / 2.0, places_over(foot.sensing_polygon))
        for index, foot in enumerate(robot.feet)
    )
    return both, left, right


def over_polygons(stated: StatedError, robot: Robot, filed: Shoe) -> tuple[Spread, Spread, Spread]:
    """What is stated of both feet, left and right in the load cases of a robot.

    Args:
        stated: of a calibration.
        robot, filed: as `load_cases` takes them.
    """
    both, left, right = load_cases(robot, filed)
    return (
        _of_both(stated, both, robot.neutral),
        _of_foot(stated, left, LEFT),
        _of_foot(stated, right, RIGHT),
    )


def _of_both(stated: StatedError, outputs: FloatArray, support: DoubleSupport) -> Spread:
    return _spread(stated.at(stated.parameters.readings(outputs)).both(turns_to(support)))


def _of_foot(stated: StatedError, outputs: FloatArray, foot: int) -> Spread:
    return _spread(stated.at(stated.parameters.readings(outputs)).foot(foot))


def _spread(stated: StatedWrench) -> Spread:
    variances = np.diagonal(stated.output_covariance, axis1=-2, axis2=-1)
    std = np.sqrt(np.clip(variances, 0.0, None))
    force = np.sqrt(np.clip(stated.covariance[:, 0, 0], 0.0, None))
    return Spread(cop(stated.wrench, MINIMUM_FORCE), force, std[:, 1:])
