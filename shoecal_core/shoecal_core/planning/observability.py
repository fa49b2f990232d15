"""What a set of double supports will tell about the gains and offsets of the channels.

Measured GRF and CoP are compared with the robot's weight and CoM. A relative gain error g_i
and an offset error o_i of channel i, whose force is f_i, act together as f_i g_i + o_i. So the
residuals' Jacobian can be predicted from forces alone, before anything has been recorded.
Forces are taken as those of a rigid body on equal springs under all channels: less varied than
real ones, hence on the safe side.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.planning.landmarks import Contour
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.sensing.wrench import columns_in_left

FloatArray = NDArray[np.float64]

_REFERENCE = ((0.0, -0.02, 0.4), (0.05, -0.03, -0.4), (-0.03, -0.02, 0.0), (0.02, -0.04, 0.2))
"""m, m, rad beside the neutral stance: far apart, whatever the robot's range."""


def contour_places(robot: Robot, support: DoubleSupport, count: int) -> FloatArray:
    """(count, 2) places evenly along the landmarks' contour, left sole's frame [m]."""
    ring = shapely.LinearRing(Contour.of(robot, support).corners)
    parts = np.arange(count) / count
    return np.array([ring.interpolate(part, normalized=True).coords[0] for part in parts])


def predicted_forces(
    shoe: Shoe, support: DoubleSupport, weight: float, places: FloatArray
) -> FloatArray:
    """(p, n) outputs of all channels, equal springs under a rigid body [N].

    Args:
        shoe: with n channels.
        support: where the right foot is.
        weight: carried by all channels together [N].
        places: (p, 2) CoP in the left sole's frame [m].
    """
    columns = columns_in_left(shoe, support)
    wrench = weight * np.column_stack([np.ones(len(places)), places[:, 1], -places[:, 0]])
    return wrench @ np.linalg.pinv(columns)


def residual_jacobian(
    shoe: Shoe, support: DoubleSupport, weight: float, places: FloatArray, forces: FloatArray
) -> FloatArray:
    """(p, 3, 2n) of GRF [N] and CoP x, y [m] to relative gains, then offsets [N].

    Args: as predicted_forces, which gives `forces` (p, n).
    """
    force, moment_x, moment_y = columns_in_left(shoe, support).T
    x, y = places[:, :1], places[:, 1:]
    rows = np.stack(
        [
            np.broadcast_to(force, forces.shape),
            (-moment_y - x * force) / weight,
            (moment_x - y * force) / weight,
        ],
        axis=1,
    )
    return np.concatenate([rows * forces[:, None, :], rows], axis=2)


def information(
    robot: Robot, shoe: Shoe, support: DoubleSupport, settings: PlannerSettings
) -> FloatArray:
    """(2n, 2n) Fisher information of one double support; those of several add up.

    The parameters are relative: gains to one, offsets to a channel's even share of the weight.
    """
    places = contour_places(robot, support, settings.places)
    forces = predicted_forces(shoe, support, robot.weight, places)
    jacobian = residual_jacobian(shoe, support, robot.weight, places, forces)
    count = len(shoe.channels)
    jacobian[..., count:] *= robot.weight / count
    jacobian /= np.array([settings.grf_noise, settings.cop_noise, settings.cop_noise])[:, None]
    rows = jacobian.reshape(-1, 2 * count)
    return rows.T @ rows


def uncertainties(total: FloatArray) -> FloatArray:
    """(2n,) standard deviations along the parameters' principal directions, smallest first.

    Directions that nothing fixes come out as infinite.
    """
    values = np.linalg.eigvalsh(total)[::-1]
    rounding = values[0] * len(values) * np.finfo(float).eps
    seen = values > rounding
    return np.where(seen, 1.0 / np.sqrt(np.where(seen, values, 1.0)), np.inf)


def rank(total: FloatArray, settings: PlannerSettings) -> int:
    """How many directions the information fixes within `fixed_below`."""
    return int(np.sum(uncertainties(total) < settings.fixed_below))


def best_rank(robot: Robot, shoe: Shoe, count: int, settings: PlannerSettings) -> int:
    """The most directions that `count` double supports can fix, were all of them allowed.

    Gains and offsets are never all of them: four cells under a stiff plate, say, cannot tell
    the offset pattern + - - +, as it changes neither force nor CoP.
    """
    neutral = robot.support_range.neutral
    total = np.zeros((2 * len(shoe.channels), 2 * len(shoe.channels)))
    for index in range(count):
        support = DoubleSupport(*(neutral + _REFERENCE[index % len(_REFERENCE)]))
        total += information(robot, shoe, support, settings)
    return rank(total, settings)
