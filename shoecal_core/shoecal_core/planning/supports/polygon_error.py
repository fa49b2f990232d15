"""Expected errors of GRF and CoP over the sensing polygons, in a few figures."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.landmarks import sensing_hull
from shoecal_core.robot.robot import Robot
from shoecal_core.shoe.expected_error import expected_error
from shoecal_core.shoe.load_cases import double_support_outputs, single_support_outputs
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters

SPACING = 0.01
"""m between neighbouring places."""


@dataclass(frozen=True)
class Expected:
    """Standard deviations over many places: their root mean square, and the largest [N or m]."""

    rms: float
    worst: float

    @classmethod
    def of(cls, deviations: FloatArray) -> Expected:
        """Of standard deviations (p,) [N or m]."""
        return cls(float(np.sqrt(np.mean(deviations**2))), float(np.max(deviations)))


@dataclass(frozen=True)
class PolygonError:
    """Expected error over the sensing polygons; errors of CoPs are lengths.

    Attributes:
        grf, cop: of both feet together, in the neutral double support, CoP anywhere in the hull
            of both sensing polygons [N, m].
        foot_grf, foot_cop: of left and right under half the weight, CoP anywhere in the foot's
            sensing polygon [N, m].
    """

    grf: Expected
    cop: Expected
    foot_grf: tuple[Expected, Expected]
    foot_cop: tuple[Expected, Expected]

    @property
    def worst_foot_cop(self) -> float:
        """Root mean square of the worse foot [m]."""
        return max(foot.rms for foot in self.foot_cop)

    def to_json(self) -> dict[str, float]:
        """Figures by their names in result files [N, mm]."""
        named = {"": (self.grf, self.cop)}
        for side, grf, cop in zip(FEET, self.foot_grf, self.foot_cop, strict=True):
            named[f"{side}_"] = (grf, cop)
        figures = {}
        for start, (grf, cop) in named.items():
            figures[f"{start}grf_std_n"] = grf.rms
            figures[f"{start}grf_worst_n"] = grf.worst
            figures[f"{start}cop_std_mm"] = 1e3 * cop.rms
            figures[f"{start}cop_worst_mm"] = 1e3 * cop.worst
        return figures


def polygon_error(
    robot: Robot,
    shoe: Shoe,
    covariance: FloatArray,
    parameters: ChannelParameters | None = None,
) -> PolygonError:
    """Expected error of gains and offsets that are uncertain.

    Loads are shared as equal springs share them; see `load_cases`.

    Args:
        robot, shoe: what stands, on n channels.
        covariance: (2n, 2n) of [gains, offsets].
        parameters: the gains and offsets; None where the covariance is one of relative gains, and
            offsets are small against the loads.

    Raises:
        ShapeError, ShoecalError: as `expected_error`.
    """

    def readings(outputs: FloatArray) -> FloatArray:
        """Readings (..., n) of outputs (..., n), in the channels' units."""
        return outputs if parameters is None else (outputs - parameters.offset) / parameters.gain

    support = robot.neutral
    places = places_over(np.array(sensing_hull(robot, support).exterior.coords))
    outputs = double_support_outputs(shoe, support, robot.weight, places)
    both = expected_error(shoe, support, outputs, readings(outputs), covariance)
    feet = []
    for index, foot in enumerate(robot.feet):
        places = places_over(foot.sensing_polygon)
        outputs = single_support_outputs(shoe, index, robot.weight / 2.0, places)
        feet.append(expected_error(shoe, None, outputs, readings(outputs), covariance))
    left, right = feet
    return PolygonError(
        grf=Expected.of(both.grf),
        cop=Expected.of(both.cop),
        foot_grf=(Expected.of(left.foot_grf[:, 0]), Expected.of(right.foot_grf[:, 1])),
        foot_cop=(Expected.of(left.foot_cop[:, 0]), Expected.of(right.foot_cop[:, 1])),
    )


def places_over(polygon: FloatArray) -> FloatArray:
    """(p, 2) corners of a convex polygon (k, 2) and a grid inside it [m]."""
    low, high = polygon.min(axis=0), polygon.max(axis=0)
    axes = [np.arange(start, end, SPACING) for start, end in zip(low, high, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    inside = shapely.contains_xy(shapely.Polygon(polygon), grid[:, 0], grid[:, 1])
    return np.concatenate((polygon, grid[inside]))
