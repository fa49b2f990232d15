"""Links of both legs that should be each other's mirror image and are not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pinocchio as pin

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_centres import centres_of

UNLIKE = 0.05
"""Of a leg's length, by which no two legs that were built alike differ: the soles of such a model
are as far from level."""


@dataclass(frozen=True)
class UnlikeLinks:
    """The link of one leg that differs most from that of the other.

    Attributes:
        joints: by name: the two at the ends of the link of the first leg, and of the other.
        lengths: from joint to joint, of both legs [m].
        off: by which the joint at the lower end is elsewhere than the mirror image of the other
            leg's [m].
        length: of the first leg from joint to joint [m].
    """

    joints: tuple[tuple[str, str], tuple[str, str]]
    lengths: tuple[float, float]
    off: float
    length: float

    @property
    def text(self) -> str:
        """Which link, by how much, and what to do."""
        (upper, lower), (other_upper, other_lower) = self.joints
        one, other = (f"{1e3 * length:.0f}" for length in self.lengths)
        return (
            f"the legs are no mirror images: {lower} is {one} mm from {upper}, {other_lower} "
            f"{other} mm from {other_upper}, and {1e3 * self.off:.0f} mm off its mirror image; "
            f"measure both, and correct the <origin> of {lower} or {other_lower}"
        )


def unlike_links(
    model: pin.Model, placements: Sequence[pin.SE3], legs: tuple[Sequence[int], Sequence[int]]
) -> UnlikeLinks | None:
    """The links that differ most; None for legs of one joint, or of unlike numbers of joints.

    Args:
        model: of the robot.
        placements: of every joint of the model in the zero pose, in the base.
        legs: joints of the model from the hip to the foot.
    """
    if len(legs[0]) != len(legs[1]) or len(legs[0]) < 2:
        return None
    centres = centres_of(model, placements)
    across = np.asarray(centres[legs[0][0]] - centres[legs[1][0]])
    if np.linalg.norm(across) < 1e-6:
        return None
    across = across / np.linalg.norm(across)
    one, other = (_steps(centres, leg) for leg in legs)
    off = _off(one, other, across)
    worst = int(off.argmax())
    # A joint's centre moves along its axis: the frame that is elsewhere may be that of the joint
    # before it.
    frames = [_steps([place.translation for place in placements], leg) for leg in legs]
    apart = np.abs(_off(frames[0], frames[1], across) - off[worst])
    at = min((worst, max(worst - 1, 0)), key=lambda step: float(apart[step]))
    left, right = (
        [(str(model.names[a]), str(model.names[b])) for a, b in pairwise(leg)][at] for leg in legs
    )
    lengths = [float(np.linalg.norm(steps[at])) for steps in frames]
    length = float(np.linalg.norm(one, axis=1).sum())
    return UnlikeLinks((left, right), (lengths[0], lengths[1]), float(off[worst]), length)


def _steps(places: Sequence[FloatArray], leg: Sequence[int]) -> FloatArray:
    """(k - 1, 3) from each of a leg's k joints to the next [m]."""
    return np.diff([places[joint] for joint in leg], axis=0)


def _off(one: FloatArray, other: FloatArray, across: FloatArray) -> FloatArray:
    """(k,) how far steps of one leg are from the mirror images of the other's [m]."""
    mirrored = other - 2.0 * np.outer(other @ across, across)
    return np.asarray(np.linalg.norm(one - mirrored, axis=1))
