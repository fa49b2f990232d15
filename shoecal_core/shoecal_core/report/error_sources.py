"""Where expected errors come from, and what would make them smaller.

Noise, prior and tolerances are independent, so their mean squares add up. The tolerances among
themselves are not: the residuals have made them agree. What one of them costs is therefore taken as
what would be won if it were known exactly: of second moments A that leaves, for tolerance k,
A - a_k a_k^T / A_kk, a_k the k-th column of A.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shoecal_core.calibration.assessment import Assessment
from shoecal_core.calibration.expected import ErrorModel, Spread
from shoecal_core.calibration.tolerances import ModelTolerances
from shoecal_core.calibration.uncertainty import Uncertainty
from shoecal_core.sensing.load_cases import single_support_outputs
from shoecal_core.sensing.wrench import ChannelParameters

FloatArray = NDArray[np.float64]

NAMED = 6
"""Causes that are named."""
FLOATING = "root_joint"
"""What Pinocchio calls the joint between world and base."""


@dataclass(frozen=True)
class Cause:
    """A tolerance of robot or shoes.

    Attributes:
        name: as `tolerances` has it.
        without: (3,) error of the CoP if it were known exactly: both feet, left, right [m].
    """

    name: str
    without: FloatArray

    @property
    def text(self) -> str:
        """Its name for a person: links are called after their joints, the base after none."""
        return self.name.replace(FLOATING, "the base link")


@dataclass(frozen=True)
class ErrorSources:
    """Root mean squares over the sensing polygons of the CoP's error: both feet, left, right [m].

    Attributes:
        total: (3,) of all.
        noise, model, prior: (3,) of each kind alone.
        causes: the tolerances that cost each foot most, the worst first; empty where the model's
            part is left out.
    """

    total: FloatArray
    noise: FloatArray
    model: FloatArray
    prior: FloatArray
    causes: tuple[Cause, ...]

    @property
    def mostly_open(self) -> bool:
        """What the data left open costs single feet more than all else."""
        return _of_feet(self.prior**2) > _of_feet(self.noise**2 + self.model**2)

    def saved(self, cause: Cause) -> float:
        """What a cause adds, in squares, to the CoP errors of single feet [m]."""
        return _of_feet(self.total**2 - cause.without**2)


def error_sources(
    assessment: Assessment, parameters: ChannelParameters, tolerances: ModelTolerances
) -> ErrorSources:
    """What the expected errors of an assessment consist of.

    Args:
        assessment: of a calibration.
        parameters: its gains and offsets.
        tolerances: that it was assessed with.
    """
    found = assessment.uncertainty
    nothing = np.zeros_like(found.noise)

    def of(part: Uncertainty) -> FloatArray:
        return sizes(ErrorModel(parameters, part, tolerances).over_polygons())

    total = sizes((assessment.both, *assessment.feet))
    noise = of(replace(found, prior=nothing, causes=()))
    prior = of(replace(found, noise=nothing, causes=()))
    model = np.sqrt(np.clip(total**2 - noise**2 - prior**2, 0.0, None))
    worst = _most_costly(parameters, found, tolerances)
    causes = [Cause(found.causes[index], of(_known(found, index))) for index in worst]
    sources = ErrorSources(total, noise, model, prior, tuple(causes))
    return replace(sources, causes=tuple(sorted(causes, key=sources.saved, reverse=True)))


def sizes(spreads: tuple[Spread, ...]) -> FloatArray:
    """Root mean square length of the CoP's error of each [m]."""
    return np.array([np.sqrt(np.nanmean(one.cop_length**2)) for one in spreads])


def _known(found: Uncertainty, index: int) -> Uncertainty:
    """The same with one tolerance known exactly."""
    column = found.agreed[:, index]
    left = found.agreed - np.outer(column, column) / column[index]
    return replace(found, agreed=left)


def _most_costly(
    parameters: ChannelParameters, found: Uncertainty, tolerances: ModelTolerances
) -> list[int]:
    """Indices of the tolerances that cost each foot most, the worst first.

    There are many: few places tell which of them are worth a look everywhere. Towards the corners
    by 1 / sqrt(3), as Gauss's rule has them, they give a rectangle's mean square.
    """
    robot, shoe = tolerances.robot, tolerances.shoe
    few = []
    for foot, shape in enumerate(robot.feet):
        middle = shape.sensing_polygon.mean(axis=0)
        places = middle + (shape.sensing_polygon - middle) / np.sqrt(3.0)
        few.append(single_support_outputs(shoe, foot, robot.weight / 2.0, places))

    def left(index: int) -> float:
        model = ErrorModel(parameters, _known(found, index), tolerances)
        feet = [model.foot(outputs, foot) for foot, outputs in enumerate(few)]
        return float((sizes(tuple(feet)) ** 2).sum())

    possible = [index for index, size in enumerate(np.diag(found.agreed)) if size > 0.0]
    return sorted(possible, key=left)[:NAMED]


def _of_feet(squares: FloatArray) -> float:
    """Root of the mean over both feet of squares (3,) of both feet together, left, right."""
    return float(np.sqrt(max(0.0, float(np.mean(squares[1:])))))
