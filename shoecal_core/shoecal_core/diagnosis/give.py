"""What gives behind an encoder, as the soles tell it: they stand, so the joints may not wander."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from shoecal_core.diagnosis.scene import Scene
from shoecal_core.diagnosis.signals import CLOSURE, FLAT_OF_CLOSURE

FloatArray = NDArray[np.float64]

LEVER = 0.12
"""m; by which shifts between the soles count against turns."""
LEAST_ANSWER = 0.03
"""Square of how much a pose must answer to a joint to tell of it."""
SMOOTH_S = 1.0
"""s; what is told of a joint is a mean over this time."""
SPENT = 1.5
"""Logarithm of evidence that each such mean costs."""
FOLLOWS = 0.5
"""Correlation with the torque from which a joint is taken to give with it."""


def told(scene: Scene, joints: Sequence[int]) -> FloatArray:
    """(T, joints) how much more encoders show than their links' angles, were all others right.

    By the pose of one sole in the other's, which may not change while both stand: of one joint
    one number explains six; of more it is the least that does [rad]. What it is in a segment's
    mean only tells how flat the soles stand.
    """
    samples = scene.samples
    course = _least(scene, joints, slice(0, 6))
    level = scene.segment_means(_least(scene, joints, FLAT_OF_CLOSURE))
    for segment in np.unique(samples.segment):
        here = samples.segment == segment
        own = uniform_filter1d(course[here], _width(scene), axis=0, mode="nearest")
        course[here] = own - own.mean(axis=0)
    return np.where(samples.both[:, None], course + level, 0.0)


def _least(scene: Scene, joints: Sequence[int], part: slice) -> FloatArray:
    """(T, joints) the same of each sample by a part of the pose alone."""
    weight = np.array([1.0 / LEVER] * 3 + [1.0] * 3)[part]
    answer = scene.answers.closure[:, part][:, :, list(joints)] * weight[:, None]
    wandered = scene.residuals[:, CLOSURE][:, part] * weight
    across = answer.transpose(0, 2, 1)
    normal = across @ answer + LEAST_ANSWER * np.eye(len(joints))
    found = np.linalg.solve(normal, across @ wandered[:, :, None])[:, :, 0]
    return np.where(scene.samples.both[:, None], found, 0.0)


def spent(scene: Scene, joints: Sequence[int]) -> float:
    """Logarithm of evidence that what is told costs: it is fitted to what it then explains."""
    numbers = min(len(joints), 6) * np.count_nonzero(scene.samples.both) / _width(scene)
    return SPENT * numbers


def with_torque(scene: Scene, joints: Sequence[int], given: FloatArray) -> float | None:
    """Compliance by which joints give with their torques [rad/(N m)]; None where they do not."""
    both = scene.samples.both[:, None]
    torque, given = (
        np.where(both, one - scene.segment_means(np.where(both, one, 0.0)), 0.0).ravel()
        for one in (scene.torque[:, list(joints)], given)
    )
    across, own, power = given @ torque, given @ given, torque @ torque
    if across <= FOLLOWS * np.sqrt(own * power) or power == 0.0:
        return None
    return float(across / power)


def _width(scene: Scene) -> int:
    samples = scene.samples
    step = float(np.median(np.diff(samples.time)[np.diff(samples.segment) == 0]))
    return max(1, round(SMOOTH_S / step))
