"""Where the right foot may be asked to stand: drafted from the legs' length and the soles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from shoecal_core.drafting.body import Body
from shoecal_core.drafting.capsules import DraftCapsule
from shoecal_core.drafting.legs import UP, LegChains
from shoecal_core.drafting.soles import Sole

FORWARD, BACKWARD, ASIDE = 0.3, 0.2, 0.25
"""Parts of the leg's length by which the right foot may stand off its neutral place."""
GAP = 0.01
"""m; least gap between soles, and half of that between shanks, where feet are parallel."""
MOST_YAW = 0.5
"""rad."""
YAW_SHARE = 0.6
"""Part of the hips' yaw limits that is asked for."""
TURNS = 0.6
"""Cosine of the angle from the vertical within which a hip's axis turns the foot."""
STEPS = 12


@dataclass(frozen=True)
class DraftRange:
    """Lower, upper, step and neutral of dx [m], dy [m] and dtheta [rad]."""

    dx: tuple[float, float, float, float]
    dy: tuple[float, float, float, float]
    dtheta: tuple[float, float, float, float]


def find_range(
    body: Body, legs: LegChains, soles: Sequence[Sole], capsules: Sequence[DraftCapsule]
) -> DraftRange:
    """A range that small humanoids reach mostly; planning leaves out what is beyond reach."""
    left, right = soles
    length = float(body.centres[legs.chains[0][0]] @ UP - left.in_base.translation @ UP)
    between = left.in_base.actInv(right.in_base).translation
    outlines = float(right.outline[:, 1].max() - left.outline[:, 1].min())
    shanks = sum(capsule.radius for capsule in capsules if capsule.name.endswith("shank"))
    nearest = -max(outlines, shanks + GAP) - GAP
    neutral = min(float(between[1]), nearest)
    yaw = min(MOST_YAW, YAW_SHARE * _yaw(body, legs))
    return DraftRange(
        dx=_axis(-BACKWARD * length, FORWARD * length, float(between[0]), 3),
        dy=_axis(neutral - ASIDE * length, nearest, neutral, 3),
        dtheta=_axis(-yaw, yaw, 0.0, 3),
    )


def _yaw(body: Body, legs: LegChains) -> float:
    """Sum over both legs of how far the foot can be turned to its less free side [rad]."""
    total = 0.0
    for chain in legs.chains:
        turning = [joint for joint in chain if abs(body.axis(joint) @ UP) > TURNS]
        total += sum(min(-low, high) for low, high in map(body.range, turning))
    return max(total, 0.1)


def _axis(
    lower: float, upper: float, neutral: float, digits: int
) -> tuple[float, float, float, float]:
    lower, upper = (float(np.round(value, digits)) for value in (lower, upper))
    neutral = float(np.clip(np.round(neutral, digits), lower, upper))
    step = max(float(np.round((upper - lower) / STEPS, digits)), 10.0**-digits)
    return lower, upper, step, neutral + 0.0
