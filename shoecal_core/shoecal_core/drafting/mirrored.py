"""Joint limits of the left and the right leg, one as the other's mirror image."""

from __future__ import annotations

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.drafting.body import Body
from shoecal_core.drafting.legs import LegChains

PARALLEL = 0.9
"""Cosine of the angle between an axis and the other one's mirror image, at least."""
SAME = 0.05
"""rad; limits that are off by less are the same."""


def crossed_limits(body: Body, legs: LegChains) -> list[tuple[int, int]]:
    """Joints of the left and the right leg whose limits fit each other with the wrong sign.

    The exporter of a mirrored leg has turned its axes but not its limits, or the other way round.
    """
    return [pair for pair in zip(*legs.chains, strict=True) if _crossed(body, legs, *pair)]


def _crossed(body: Body, legs: LegChains, left: int, right: int) -> bool:
    turn = body.axis(left)
    # The mirror image of a turn: what lies in the mirror changes its sign, what is across does not.
    mirrored = 2.0 * (turn @ legs.left) * legs.left - turn
    along = float(mirrored @ body.axis(right))
    if abs(along) < PARALLEL:
        return False
    ours, theirs = np.array(body.range(left)), np.array(body.range(right))
    alike, crossed = (theirs, -theirs[::-1]) if along > 0.0 else (-theirs[::-1], theirs)
    return not _same(ours, alike) and _same(ours, crossed)


def _same(ours: FloatArray, theirs: FloatArray) -> bool:
    return bool(np.abs(ours - theirs).max() < SAME)
