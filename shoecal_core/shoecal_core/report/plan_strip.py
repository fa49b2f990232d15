"""Pictures of the robot along one planned motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from shoecal_core.report.page import StillStrip
from shoecal_core.report.plan_content import PlannedMotion
from shoecal_core.report.scene.stills import StillInstant, instant, stills
from shoecal_core.shoe.shoe import Shoe

COUNT = 6
"""Instants shown."""


CAPTION = (
    "As planned; limbs are as thick as their mass requires. Red arrow: the force on the floor, "
    "at the CoP; red line: where the CoP has been, both seen through legs and feet; "
    "dashed: from the CoM down. Left leg blue, right leg orange; the lighter floor is the hull of "
    "the sensing polygons."
)


def plan_strips(motions: Sequence[PlannedMotion], shoe: Shoe) -> list[StillStrip]:
    """Instants of each motion, at equal distances in time.

    Raises:
        NoPictureError: where nothing can draw them.
    """
    instants = [
        [instant_of(planned, sample) for sample in _samples(planned)] for planned in motions
    ]
    drawn = stills(motions[0].robot, shoe, instants)
    return [StillStrip("The robot", pictures, CAPTION) for pictures in drawn]


def _samples(planned: PlannedMotion) -> list[int]:
    last = len(planned.motion.time) - 1
    return [int(sample) for sample in np.linspace(0, last, COUNT).round()]


def instant_of(planned: PlannedMotion, sample: int) -> StillInstant:
    """The robot at a sample of the motion."""
    stance = int(planned.stance[sample])
    turns, places = planned.soles
    return instant(
        planned.robot, f"{planned.motion.time[sample]:.1f} s", planned.motion.positions[sample],
        planned.cop[sample], 1.0, planned.cop[: sample + 1 : 5], stance,
        pin.SE3(turns[sample, stance], places[sample, stance]),
    )  # fmt: skip
