"""How well a set of double supports identifies the gains and offsets of the channels.

Measured GRF and CoP are compared with the robot's weight and CoM. A relative gain error g_i
and an offset error o_i of channel i, whose output is f_i, act together as f_i g_i + o_i. So the
residuals' Jacobian can be predicted from outputs alone, before anything has been recorded: they
are taken as those of a rigid body on equal springs under all channels, give or take UNEVEN_SHARE,
without which a real robot would show more of its gains than predicted. (In a fit,
where f_i = c_i S_i + d_i, a relative gain error acts on c_i S_i alone. Its offset error is
o_i + d_i g_i in terms of those here.)

Errors of the model stay alike for a while, so samples within one correlation time count as one,
as in the fit. Errors and priors are those that the fit's settings have by default.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShapeError
from shoecal_core.planning.landmarks import Contour
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.load_cases import double_support_outputs
from shoecal_core.shoe.priors import TORQUE_LEVER_M, PriorSettings, parameter_std
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import (
    ChannelParameters,
    at_cop,
    by_parameters,
    columns_in_left,
    cop_jacobian,
)

_REFERENCE = ((0.0, -0.02, 0.4), (0.05, -0.03, -0.4), (-0.03, -0.02, 0.0), (0.02, -0.04, 0.2))
"""m, m, rad from the neutral stance: far apart, whatever the robot's range."""
PLACES = 40
"""CoP places of a double support."""
FORCE_STD_N, COP_STD_M = 0.3, 0.0025
"""Of GRF and CoP, errors of modelling included."""
UNEVEN_SHARE = 0.3
"""How far the feet share the load otherwise than equal springs, over an even share of the weight.
"""


@dataclass(frozen=True)
class Visit:
    """What the CoP does in one double support.

    Attributes:
        support: where the right foot is.
        places: (p, 2) CoP at even times, left sole's frame [m].
        duration: of the motion [s].
    """

    support: DoubleSupport
    places: FloatArray
    duration: float

    def __post_init__(self) -> None:
        if self.places.ndim != 2 or self.places.shape[1] != 2 or not len(self.places):
            raise ShapeError("places", "(p, 2)", self.places.shape)

    @classmethod
    def expected(cls, robot: Robot, support: DoubleSupport, settings: PlannerSettings) -> Visit:
        """Before planning: once around the landmarks' contour, as fast as the CoM may go."""
        length = shapely.LinearRing(Contour.of(robot, support).corners).length
        duration = length / settings.com_speed + 2.0 * settings.hold_time
        return cls(support, contour_places(robot, support, PLACES), float(duration))


def contour_places(robot: Robot, support: DoubleSupport, count: int) -> FloatArray:
    """(count, 2) places evenly along the landmarks' contour, left sole's frame [m]."""
    ring = shapely.LinearRing(Contour.of(robot, support).corners)
    parts = np.arange(count) / count
    return np.array([ring.interpolate(part, normalized=True).coords[0] for part in parts])


def residual_jacobian(
    shoe: Shoe, support: DoubleSupport, weight: float, places: FloatArray
) -> FloatArray:
    """(p, 3, 2n) of GRF [N] and CoP x, y [m] to relative gains, then offsets [N or N m].

    Args:
        shoe: with n channels.
        support: where the right foot is.
        weight: on the floor [N].
        places: (p, 2) CoP in the left sole's frame [m].
    """
    outputs = double_support_outputs(shoe, support, weight, places)
    wrench = at_cop(np.full(len(places), weight), places)
    return by_parameters(cop_jacobian(wrench) @ columns_in_left(shoe, support).T, outputs)


def information(robot: Robot, shoe: Shoe, visit: Visit) -> FloatArray:
    """(2n, 2n) Fisher information of one double support; those of several add up.

    The parameters are relative: gains to one, offsets to a channel's even share of the weight.
    """
    count = len(shoe.channels)
    noise = np.array([FORCE_STD_N, COP_STD_M, COP_STD_M])
    jacobian = residual_jacobian(shoe, visit.support, robot.weight, visit.places) / noise[:, None]
    rows = jacobian.reshape(-1, 2 * count)
    total = rows.T @ rows
    # A gain's column is the offset's times the output, so the mean square counts.
    slopes = rows[:, count:]
    uneven = uneven_share(robot, shoe, visit.support, UNEVEN_SHARE)
    total[:count, :count] += (slopes.T @ slopes) * uneven
    independent = visit.duration / PriorSettings().correlation_s
    scale = parameter_scale(robot, shoe)
    weighted: FloatArray = total * np.outer(scale, scale) * (independent / len(visit.places))
    return weighted


def uneven_share(robot: Robot, shoe: Shoe, support: DoubleSupport, part: float) -> FloatArray:
    """(n, n) covariance of the outputs around those of a rigid body on equal springs.

    Legs and gears give, so the feet share force and moments otherwise; the sum stays. Each foot's
    plate is stiff: its channels share what the foot carries as equal springs do.

    Args:
        robot, shoe: on n channels.
        support: where the right foot is.
        part: standard deviation along each such pattern, over an even share of the weight.
    """
    count = len(shoe.channels)
    size = np.full(count, part * robot.weight / count)
    size[shoe.torque] *= TORQUE_LEVER_M
    by_foot = np.zeros((count, 6))
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        basis, _ = np.linalg.qr(shoe.columns[own] * size[own, None])
        by_foot[own, 3 * foot : 3 * foot + 3] = basis
    total = (columns_in_left(shoe, support) * size[:, None]).T @ by_foot
    # Of the feet's six forces and moments, those without a sum: what the three rows of it leave.
    internal = np.eye(6) - np.linalg.pinv(total) @ total
    patterns = size[:, None] * by_foot
    covariance: FloatArray = patterns @ internal @ patterns.T
    return covariance


def parameter_scale(robot: Robot, shoe: Shoe) -> FloatArray:
    """(2n,) one for each relative gain, a channel's even share of the weight for each offset."""
    count = len(shoe.channels)
    return np.concatenate((np.ones(count), np.full(count, robot.weight / count)))


def prior_information(robot: Robot, shoe: Shoe) -> FloatArray:
    """(2n, 2n) what is believed before any sample, in `information`'s units."""
    expected = parameter_std(shoe, np.ones(len(shoe.channels)), robot.weight, PriorSettings())
    return np.diag((parameter_scale(robot, shoe) / expected) ** 2)


def relative_information(
    robot: Robot, shoe: Shoe, parameters: ChannelParameters, fitted: FloatArray
) -> FloatArray:
    """(2n, 2n) information of a fit in the units and meaning of `information`.

    Args:
        robot, shoe: whose n channels these are.
        parameters: the fitted gains and offsets.
        fitted: (2n, 2n) information of [gains, offsets].
    """
    turn = from_relative(robot, shoe, parameters)
    relative: FloatArray = turn.T @ fitted @ turn
    return relative


def from_relative(robot: Robot, shoe: Shoe, parameters: ChannelParameters) -> FloatArray:
    """(2n, 2n) turns errors of relative parameters into errors of [gains, offsets]."""
    count = len(shoe.channels)
    turn = np.diag(parameter_scale(robot, shoe))
    turn[:count, :count] = np.diag(parameters.gain)
    turn[count:, :count] = np.diag(parameters.offset)
    return turn


def uncertainties(total: FloatArray) -> FloatArray:
    """(2n,) standard deviations along the parameters' principal directions, smallest first.

    Directions that nothing fixes come out as infinite.
    """
    values = np.linalg.eigvalsh(total)[::-1]
    seen = values > _rounding(values)
    return np.where(seen, 1.0 / np.sqrt(np.where(seen, values, 1.0)), np.inf)


def observable(total: FloatArray) -> FloatArray:
    """(2n, r) orthonormal directions on which the information says anything at all."""
    values, vectors = np.linalg.eigh(total)
    return np.asarray(vectors[:, values > _rounding(values)])


def _rounding(eigenvalues: NDArray[np.floating[Any]]) -> float:
    """Eigenvalues up to this are zero."""
    return float(eigenvalues.max() * len(eigenvalues) * np.finfo(float).eps)


def rank(total: FloatArray, settings: PlannerSettings) -> int:
    """Number of directions that information (2n, 2n) fixes within `fixed_below`."""
    return int(np.sum(uncertainties(total) < settings.fixed_below))


def reference_information(
    robot: Robot, shoe: Shoe, count: int, settings: PlannerSettings
) -> FloatArray:
    """(2n, 2n) of `count` far-apart double supports of differing yaw, were they all allowed."""
    neutral = robot.support_range.neutral
    total = np.zeros((2 * len(shoe.channels), 2 * len(shoe.channels)))
    for index in range(count):
        support = DoubleSupport(*(neutral + _REFERENCE[index % len(_REFERENCE)]))
        total += information(robot, shoe, Visit.expected(robot, support, settings))
    return total


def best_rank(robot: Robot, shoe: Shoe, count: int, settings: PlannerSettings) -> int:
    """The most directions that `count` double supports can fix, were all of them allowed.

    Gains and offsets are never all of them: four cells under a stiff plate, say, cannot show
    the offset pattern + - - +, as it changes neither force nor CoP.
    """
    return rank(reference_information(robot, shoe, count, settings), settings)
