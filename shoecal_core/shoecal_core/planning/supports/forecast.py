"""What data will tell before they are recorded: uncertainties, errors, weak directions."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.errors import ShapeError
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.supports.feasible import Feasible
from shoecal_core.planning.supports.observability import (
    Visit,
    information,
    observable,
    parameter_scale,
    prior_information,
    rank,
    reference_information,
)
from shoecal_core.planning.supports.polygon_error import PolygonError, polygon_error
from shoecal_core.sensing.directions import describe_direction
from shoecal_core.sensing.shoe import Shoe

FloatArray = NDArray[np.float64]
CANDIDATES = 200
"""Double supports looked at for the best to add: with more the best hardly gets better."""


@dataclass(frozen=True)
class WeakDirection:
    """A direction of the parameters that the data leave open, though others could fix it.

    Attributes:
        words: what changes along it.
        uncertainty: relative, infinite where the data say nothing.
    """

    words: str
    uncertainty: float


@dataclass(frozen=True)
class Forecast:
    """What some data will tell about n channels, if the model errs as the settings say.

    Attributes:
        gain_std: (n,) relative standard uncertainty of each gain, prior included.
        offset_std: (n,) of each offset, likewise [N or N m]. Patterns that no data fix, as they
            change neither force nor CoP, are left out of both.
        uncertainties: (r,) by the data alone along the r directions that any data see, smallest
            first, infinite where these say nothing; gains relative to one, offsets to a
            channel's even share of the weight.
        rank: how many of them are fixed.
        possible: how many far-apart double supports of differing yaw would fix; never below `rank`.
        weak: those that are not fixed.
        error: expected errors of GRF and CoP over the sensing polygons.
    """

    gain_std: FloatArray
    offset_std: FloatArray
    uncertainties: FloatArray
    rank: int
    possible: int
    weak: tuple[WeakDirection, ...]
    error: PolygonError

    def __post_init__(self) -> None:
        if self.gain_std.shape != self.offset_std.shape:
            raise ShapeError("offset_std", str(self.gain_std.shape), self.offset_std.shape)

    @property
    def singular_values(self) -> FloatArray:
        """(r,) of the whitened Jacobian, largest first."""
        values: FloatArray = 1.0 / self.uncertainties
        return values

    def to_json(self) -> dict[str, object]:
        """For result files [N, mm]; an infinite uncertainty is null."""
        return {
            "gain_std": self.gain_std.tolist(),
            "offset_std_n": self.offset_std.tolist(),
            "singular_values": self.singular_values.tolist(),
            "rank": self.rank,
            "possible_rank": self.possible,
            "weak_directions": [
                {
                    "direction": weak.words,
                    "uncertainty": weak.uncertainty if np.isfinite(weak.uncertainty) else None,
                }
                for weak in self.weak
            ],
            "expected_error": self.error.to_json(),
        }


@dataclass(frozen=True)
class Addition:
    """A double support to add, and what it brings.

    Attributes:
        support: where the right foot is.
        forecast: with it, and with those recommended before it.
    """

    support: DoubleSupport
    forecast: Forecast

    @property
    def words(self) -> str:
        """Where to put the right foot."""
        return describe_support(self.support)

    def to_json(self) -> dict[str, object]:
        """For result files: dx [m], dy [m], dtheta [rad], and the forecast with it."""
        support = self.support
        return {
            "support": [support.dx, support.dy, support.dtheta],
            "forecast": self.forecast.to_json(),
        }


def forecast(robot: Robot, shoe: Shoe, known: FloatArray, settings: PlannerSettings) -> Forecast:
    """What data of this information tell.

    Args:
        robot, shoe: who is calibrated, with n channels.
        known: (2n, 2n) of `information`, or of a fit by `relative_information`.
        settings: of planning.
    """
    scale = parameter_scale(robot, shoe)
    reference = reference_information(robot, shoe, settings.training_supports, settings)
    seen = observable(reference)
    prior = prior_information(robot, shoe)
    relative = seen @ np.linalg.inv(seen.T @ (known + prior) @ seen) @ seen.T
    std = np.sqrt(np.diag(relative)) * scale
    values, vectors = np.linalg.eigh(seen.T @ known @ seen)
    order = np.argsort(-values)
    spread = _deviations(values[order], float(np.trace(known)))
    directions = (seen @ vectors[:, order]).T
    fixed = spread < settings.fixed_below
    return Forecast(
        gain_std=std[: len(std) // 2],
        offset_std=std[len(std) // 2 :],
        uncertainties=spread,
        rank=int(fixed.sum()),
        possible=max(int(fixed.sum()), rank(reference, settings)),
        weak=tuple(
            WeakDirection(describe_direction(shoe, direction), float(uncertainty))
            for direction, uncertainty in zip(directions[~fixed], spread[~fixed], strict=True)
        ),
        error=polygon_error(robot, shoe, relative * np.outer(scale, scale)),
    )


def forecast_visits(
    robot: Robot, shoe: Shoe, visits: Sequence[Visit], settings: PlannerSettings
) -> Forecast:
    """What the data of some double supports will tell."""
    return forecast(robot, shoe, total_information(robot, shoe, visits), settings)


def worst_part(
    robot: Robot, shoe: Shoe, visits: Sequence[Visit], count: int, settings: PlannerSettings
) -> tuple[tuple[int, ...], Forecast]:
    """The `count` of some double supports whose worst direction is the most uncertain.

    Returns:
        Their indices, and what their data will tell.
    """
    parts = np.array([information(robot, shoe, visit) for visit in visits])
    prior = prior_information(robot, shoe)
    seen = observable(reference_information(robot, shoe, settings.training_supports, settings))
    chosen = list(itertools.combinations(range(len(visits)), count))
    totals = np.array([parts[list(indices)].sum(axis=0) for indices in chosen])
    worst = int(np.argmin(_least(seen.T @ (totals + prior) @ seen)))
    return chosen[worst], forecast(robot, shoe, totals[worst], settings)


def total_information(robot: Robot, shoe: Shoe, visits: Sequence[Visit]) -> FloatArray:
    """(2n, 2n) of several double supports together."""
    total = np.zeros((2 * len(shoe.channels), 2 * len(shoe.channels)))
    for visit in visits:
        total += information(robot, shoe, visit)
    return total


def best_additions(
    robot: Robot, shoe: Shoe, known: FloatArray, settings: PlannerSettings, count: int = 1
) -> list[Addition]:
    """The double supports of the robot's range that make the worst direction least uncertain.

    One after the other, each beside the ones before it. Fewer where the robot can stand in none.

    Args:
        robot, shoe, known, settings: as `forecast`.
        count: how many to find.
    """
    feasible = Feasible(robot, settings)
    everywhere = feasible.apart()
    kept = np.random.default_rng(0).permutation(len(everywhere))[:CANDIDATES]
    supports = [everywhere[index] for index in sorted(kept.tolist())]
    parts = [
        information(robot, shoe, Visit.expected(robot, support, settings)) for support in supports
    ]
    seen = observable(reference_information(robot, shoe, settings.training_supports, settings))
    prior = prior_information(robot, shoe)
    additions: list[Addition] = []
    for _ in range(count):
        scores = _least(seen.T @ (known + prior + np.array(parts)) @ seen)
        best = (int(index) for index in np.argsort(-scores))
        found = next((index for index in best if feasible.can_stand(supports[index])), None)
        if found is None:
            break
        known = known + parts[found]
        additions.append(Addition(supports[found], forecast(robot, shoe, known, settings)))
    return additions


def describe_support(support: DoubleSupport) -> str:
    """Where the right foot stands, in words."""
    return (
        f"right foot at dx {support.dx:g} m, dy {support.dy:g} m, yaw {support.dtheta:g} rad "
        f"({np.degrees(support.dtheta):.0f} deg) of the left"
    )


def _least(information: FloatArray) -> FloatArray:
    """Smallest eigenvalue of information (..., r, r): of the most uncertain direction."""
    return np.asarray(np.linalg.eigvalsh(information)[..., 0])


def _deviations(values: FloatArray, size: float) -> FloatArray:
    """Standard deviations of eigenvalues, infinite where these are rounding at this size."""
    seen = values > size * len(values) * np.finfo(float).eps
    return np.where(seen, 1.0 / np.sqrt(np.where(seen, values, 1.0)), np.inf)
