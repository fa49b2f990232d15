"""One shoe under known weights: what it should have measured, and what it did."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.manual.assembly import shoe_wrench
from shoecal_core.manual.loads import Load
from shoecal_core.manual.measurements import Measurements, stacked
from shoecal_core.robot.gravity import GRAVITY
from shoecal_core.shoe.sensing import MINIMUM_FORCE
from shoecal_core.shoe.shoe import FEET, Shoe
from shoecal_core.shoe.wrench import ChannelParameters, at_cop, cop, foot_wrenches

FORCE_ERROR, FORCE_SHARE = 0.5, 0.05
"""N, and share of the force: further off, another weight stood there."""


@dataclass(frozen=True)
class ShoeLoads:
    """N loads of one shoe, without the bare one.

    Attributes:
        foot: index into FEET.
        loads: weights and holes.
        outputs: (N, k) of the foot's cells [N].
        force, cop: (N,) [N] and (N, 2) [m] measured, uncorrected; shoe included. The CoP is NaN
            where the channels give a force alone.
        expected_force, expected_cop: what the weight and the shoe's own weight make them.
    """

    foot: int
    loads: tuple[Load, ...]
    outputs: FloatArray
    force: FloatArray
    cop: FloatArray
    expected_force: FloatArray
    expected_cop: FloatArray

    @property
    def masses(self) -> FloatArray:
        """(N,) [kg]."""
        return np.array([load.mass for load in self.loads])


def expected_wrenches(shoe: Shoe, foot: int, masses: FloatArray, places: FloatArray) -> FloatArray:
    """(N, 3) floor wrenches of a shoe with weights (N,) [kg] at places (N, 2) of its top plate.

    The floor bears the whole shoe, too: so does what `foot_wrenches` measures.
    """
    wrenches: FloatArray = at_cop(masses * GRAVITY, places) + shoe_wrench(shoe, foot)
    return wrenches


def loaded(loads: Measurements, foot: int, parameters: ChannelParameters) -> ShoeLoads:
    """Every load of one shoe by parameters of the assembled shoe.

    Raises:
        ShoecalError: when a weight is not the one that stood there, or no weight was read at all.
    """
    shoe = loads.shoe
    entries = [entry for entry in loads.of_foot(foot) if entry.load.place]
    holes = shoe.holes[foot]
    if not entries or holes is None:
        raise loads.error(f"the {FEET[foot]} shoe was not loaded; read it under its weights")
    masses, means, _ = stacked(entries)
    readings = np.zeros((len(entries), len(shoe.names)))
    channels = shoe.of_foot(foot)
    readings[:, channels] = means
    outputs = parameters.outputs(readings)
    measured = foot_wrenches(shoe, outputs)[:, foot]
    places = np.array([holes.position(entry.load.place) for entry in entries])
    expected = expected_wrenches(shoe, foot, masses, places)
    place = cop(measured, MINIMUM_FORCE)
    if not shoe.gives_cop[foot]:
        place[:] = np.nan
    found = ShoeLoads(
        foot=foot,
        loads=tuple(entry.load for entry in entries),
        outputs=outputs[:, channels],
        force=measured[:, 0],
        cop=place,
        expected_force=expected[:, 0],
        expected_cop=cop(expected, 0.0),
    )
    _check_weights(loads, found)
    return found


def wrong_weight(load: Load, force: float, expected: float) -> str:
    """What is wrong with the force [N] measured under a load, empty when nothing is."""
    if abs(force - expected) <= FORCE_ERROR + FORCE_SHARE * abs(expected):
        return ""
    weighs = load.mass + (force - expected) / GRAVITY
    return f"{load}: weighs {weighs:.2f} kg; see which weight is there and read it again"


def _check_weights(loads: Measurements, found: ShoeLoads) -> None:
    wrong = [
        problem
        for load, force, expected in zip(
            found.loads, found.force, found.expected_force, strict=True
        )
        if (problem := wrong_weight(load, float(force), float(expected)))
    ]
    if len(wrong) > len(found.loads) / 2:
        ratio = float(np.median(found.force / found.expected_force))
        raise loads.error(
            f"{FEET[found.foot]} shoe: most loads weigh {ratio:.2f} of what they are; the cells' "
            "calibration is of other cells or of weights in another unit"
        )
    light = [load for load, place in zip(found.loads, found.cop, strict=True) if np.isnan(place[0])]
    if light and loads.shoe.gives_cop[found.foot]:
        raise loads.error(
            f"{light[0]}: too light for a CoP, which needs {MINIMUM_FORCE:g} N on the foot; leave "
            "it out"
        )
    if wrong:
        more = f" (and {len(wrong) - 1} more)" if len(wrong) > 1 else ""
        raise loads.error(wrong[0] + more)
