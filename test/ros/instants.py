"""Readings and joint angles as the inputs hand them over."""

from __future__ import annotations

import numpy as np

from ros.bodies import nao_shoe
from shoecal_ros.inputs.joining import Joined
from shoecal_ros.inputs.joints import JointBatch

STEP_NS = 100_000_000
COUNT = len(nao_shoe().names)


def joined(step: int, value: float = 1.0, *, bad: int | None = None) -> Joined:
    """All readings of one instant alike; one of them may be none."""
    status = np.zeros(COUNT, dtype=np.uint8)
    if bad is not None:
        status[bad] = 2
    return Joined(step * STEP_NS, np.full(COUNT, value), status, np.ones(COUNT, dtype=np.bool_))


def batch(value: float = 0.0) -> JointBatch:
    """Three joints at one instant, all alike."""
    return JointBatch(np.zeros(1, dtype=np.int64), np.full((1, 3), value))
