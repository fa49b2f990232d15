"""Robots that stand still on cells whose laws are known."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from core.estimation import synthetic
from shoecal_core.arrays import FloatArray
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.estimation.checks.standstill import ModelTolerance
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.shoe.correction import CopCorrection
from shoecal_core.shoe.shoe import Shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, weight_below

WEIGHT = 54.0
HEIGHT = 0.25
LIFT = 0.03
"""How high a hanging foot is above the other [m]."""
TOLERANCE = ModelTolerance(force=0.3, cop=0.0025)
BOTH = (0.55 * WEIGHT, 0.45 * WEIGHT)
COPS = np.array([[0.02, 0.005], [0.03, -0.01]])
"""True CoP of left, right, each in its own sole's frame [m]."""


@dataclass(frozen=True)
class Standing:
    """A standstill.

    Attributes:
        felt: (n,) true outputs of the channels.
        body: what the joints say.
    """

    felt: FloatArray
    body: BodyStates

    def readings(self, truth: ChannelParameters) -> FloatArray:
        """(n,) of channels with this law."""
        found: FloatArray = (self.felt - truth.offset) / truth.gain
        return found


def stand(
    shoe: Shoe,
    forces: tuple[float, float] = BOTH,
    support: DoubleSupport = synthetic.SUPPORTS[1],
    *,
    off: FloatArray | None = None,
) -> Standing:
    """Feet carry these forces [N] at COPS; a foot without any is lifted.

    Args:
        shoe: worn.
        forces: left, right.
        support: where the right foot is.
        off: (2,) of the modelled CoP, left sole's frame [m].
    """
    right = support.right_to_left(COPS[1])
    total = sum(forces)
    place = (forces[0] * COPS[0] + forces[1] * right) / total if total else np.zeros(2)
    height = LIFT * (float(not forces[1]) - float(not forces[0]))
    return Standing(
        outputs(shoe, forces), body(place if off is None else place + off, support, height)
    )


def outputs(shoe: Shoe, forces: tuple[float, float]) -> FloatArray:
    """(n,) outputs of channels that feel these forces [N] at COPS."""
    found = np.zeros(len(shoe.names))
    for foot in (0, 1):
        own = shoe.of_foot(foot)
        wanted = at_cop(np.array(forces[foot]), COPS[foot]) - weight_below(shoe)[foot]
        found[own] = np.linalg.lstsq(shoe.columns[own].T, wanted, rcond=None)[0]
    return found


def body(cop_left: FloatArray, support: DoubleSupport, height: float = 0.0) -> BodyStates:
    """A body whose CoM is above a place of the left sole's frame [m].

    Args:
        cop_left: the place.
        support: where the right foot is.
        height: of the right foot above the left [m].
    """
    rotation = np.eye(3)
    rotation[:2, :2] = support.rotation
    places = np.stack([cop_left, support.left_to_right(cop_left)])
    com = np.column_stack([places, [HEIGHT, HEIGHT - height]])
    return BodyStates(
        com=com[None],
        rotation=rotation[None],
        translation=np.array([[support.dx, support.dy, height]]),
        left_rotation=np.eye(3)[None],
        left_translation=np.zeros((1, 3)),
    )


def calibration(shoe: Shoe, parameters: ChannelParameters, **changes: object) -> Calibration:
    """A self-calibration with these parameters."""
    made = Calibration(
        "old", "self", 10**9, "robot", shoe.name, "r", "s", shoe.names, parameters, None,
        (), WEIGHT, 0.0, float("nan"), "PASS", ("fine",), ("run",),
    )  # fmt: skip
    if changes.get("source", "self") != "self":
        changes = {"fitted_runs": (), **changes}
    return replace(made, **changes)  # type: ignore[arg-type]


def drifted(truth: ChannelParameters, drift: FloatArray) -> ChannelParameters:
    """What was true before cells drifted by less than nothing of this [N]."""
    return ChannelParameters(truth.gain, truth.offset + drift)


def corrections(shoe: Shoe, rng: np.random.Generator) -> tuple[CopCorrection, ...]:
    """CoP corrections of both feet, some millimetres each."""
    return tuple(
        CopCorrection(
            foot,
            x=np.concatenate([[0.3, 0.02, 0.01, 1e-3], rng.normal(0.0, 1e-5, count)]),
            y=np.concatenate([[0.3, 0.02, 0.01, 1e-3], rng.normal(0.0, 1e-5, count)]),
            cop_range=np.array([[-1.0, -1.0], [1.0, 1.0]]),
            output_range=np.array([np.full(count, -99.0), np.full(count, 99.0)]),
        )
        for foot in (0, 1)
        for count in [len(shoe.of_foot(foot))]
    )


def spread(shoe: Shoe, rng: np.random.Generator, force: float = 0.02) -> FloatArray:
    """(2n, 2n) covariance of gains and offsets, correlated, about `force` [N] each at work."""
    count = len(shoe.names)
    mixed = rng.normal(0.0, force / np.sqrt(2 * count), (2 * count, 2 * count))
    mixed[:count] *= 0.3
    found: FloatArray = mixed @ mixed.T
    return found
