"""The joint fit once more, with gears that give and have play in every form that is known.

The joint fit lets gears give in one form: soles on the floor hold still, by the joint angles too.
Of a robot whose motors give way to the forces between its feet, the angles show those turns, the
right sole seems to move against the left one, and zeros take up what no gear may. Where zeros come
out far off, the fit is therefore solved again, with gears as wide as their tolerances and free.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.error_sources.base import ALL, Place, as_built_std
from shoecal_core.error_sources.deviation import Deviation
from shoecal_core.error_sources.effects import body, places
from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.estimation.joint_fit import FittedDeviation, JointFit

GEARS: tuple[body.JointCompliance | body.Backlash, ...] = (body.JointCompliance(), body.Backlash())

EXACT = 1e-9
"""rad, rad/(N m): standard deviation of gears that are taken for exact."""


@dataclass(frozen=True)
class FreedGears:
    """What a joint fit comes to with gears in every form.

    Attributes:
        deviations: all but those of the gears, in the fit's order.
        given: by joint of the legs: how far its link lies off what its encoder shows [rad], root
            mean square over the samples, as its gear gives and has play.
        cost_share: the sum of whitened squares that is left, over that of the fit.
    """

    deviations: tuple[FittedDeviation, ...]
    given: dict[str, float]
    cost_share: float


def free_gears(fit: JointFit, tolerances: Tolerances) -> FreedGears:
    """Solve a joint fit once more about where it settled, its gears being free in form.

    Args:
        fit: of the training runs.
        tolerances: how far robot and shoes may be off their files.
    """
    signal_model = fit.system.signal_model
    gears = list(_gears(signal_model, tolerances))
    system = fit.system.with_others(
        frozenset(gear.identifier for gear in GEARS), [one for one, _ in gears]
    )
    solution = system.solution()
    first = 2 * len(fit.parameters.gain) + 1
    own = slice(first, first + len(system.deviations))
    stds = np.sqrt(np.diag(system.covariance())[own])
    fitted = [
        FittedDeviation(one, float(value), float(std))
        for one, value, std in zip(system.deviations, solution[own], stds, strict=True)
    ]
    there = (system.scale > 0.0).any(axis=1)
    given = np.zeros_like(signal_model.samples.angles)
    for one, (_, angles) in zip(fitted[-len(gears) :], gears, strict=True):
        given += one.value * angles
    robot = signal_model.samples.robot
    size = np.sqrt(np.mean(given[there] ** 2, axis=0))
    return FreedGears(
        deviations=tuple(fitted[: -len(gears)]),
        given={robot.joint_names[joint]: float(size[joint]) for joint in robot.moved},
        cost_share=system.cost(solution) / fit.cost,
    )


def _gears(
    signal_model: SignalModel, tolerances: Tolerances
) -> Iterator[tuple[Deviation, FloatArray]]:
    """Compliance and play of all joints alike and of each, in each form; and the (T, m) that
    encoders show more by a unit [rad].
    """
    weight = signal_model.samples.robot.weight
    for gear in GEARS:
        (component,) = gear.components
        std = as_built_std(component, tolerances, weight)
        everywhere: list[Place] = [(ALL,), *places.each_joint(signal_model)]
        for place in everywhere:
            forms = list(gear.angles(signal_model, place))
            share = 1.0 if place == (ALL,) else tolerances.gear_spread
            for angles in forms:
                yield (
                    Deviation(
                        gear.identifier, place, component.name, component.unit,
                        max(share * std / np.sqrt(len(forms)), EXACT),
                        signal_model.by_angles(angles),
                    ),
                    angles,
                )  # fmt: skip
