"""The animation of one planned motion."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from shoecal_core.report.figures.body_points import BodyPoints, body_points
from shoecal_core.report.figures.feet_from_above import Ground, from_above
from shoecal_core.report.figures.stick_figure import from_the_side
from shoecal_core.report.page import Player
from shoecal_core.report.plan_body import moved, polygons
from shoecal_core.report.plan_content import BOTH, PlannedMotion
from shoecal_core.report.plan_figures import hulls
from shoecal_core.report.player import PlayerFrames

FloatArray = NDArray[np.float64]

RATE = 10.0
"""Frames a second: motions are slow, and between frames the page interpolates."""
CAPTION = (
    "Computed from the model: nothing was measured. The robot moves slowly; 4× is a good speed to "
    "look at."
)
IN_THE_AIR = "Soles with a dashed outline are in the air."


def animation(planned: PlannedMotion) -> Player:
    """The motion as stick figures and from above, with a still of its middle."""
    time = planned.motion.time
    count = max(2, int(np.ceil(planned.motion.duration * RATE)) + 1)
    samples = np.round(np.linspace(0, len(time) - 1, count)).astype(int)
    motion_points = body_points(
        [moved(planned, sample) for sample in samples],
        [polygons(planned, sample) for sample in samples],
        [capsule.radius for capsule in planned.robot.capsules],
        lifted(planned, samples),
    )
    still = count // 2
    moment = round(float(time[samples[still]]), 1)
    label = f"{moment:.1f} s"
    ground = Ground(hulls(planned), planned.marks, planned.settings.landmark_radius)
    return Player(
        title="The motion",
        svgs=(
            from_the_side(motion_points, still, label),
            from_above(motion_points, ground, still, label),
        ),
        frames=frames(planned, motion_points).to_json(),
        duration=round(planned.motion.duration, 1),
        still=moment,
        caption=f"{CAPTION} {IN_THE_AIR}" if motion_points.lifted.strip("-") else CAPTION,
    )


def frames(planned: PlannedMotion, motion_points: BodyPoints) -> PlayerFrames:
    """Points of the body in mm, those of CoM and CoP a digit finer."""
    decimals = [0] * motion_points.points.shape[1]
    decimals[motion_points.com] = decimals[motion_points.cop] = 1
    return PlayerFrames(
        planned.motion.duration, motion_points.points, motion_points.lifted, tuple(decimals)
    )


def lifted(planned: PlannedMotion, samples: NDArray[np.int64]) -> str:
    """A letter for each of the samples (k,): the foot in the air, `-` for none."""
    letters = np.full(len(planned.motion.time), "-")
    for stand in planned.stands:
        if stand.feet != BOTH:
            letters[stand.begin : stand.end] = "r" if stand.feet == "left" else "l"
    return "".join(letters[samples])
