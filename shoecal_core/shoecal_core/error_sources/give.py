"""What gives behind an encoder, as the soles tell it: they stand, so the joints may not wander."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter1d

from shoecal_core.error_sources.signals import FLAT_OF_CLOSURE
from shoecal_core.samples.samples import Samples

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


@dataclass(frozen=True)
class Given:
    """What some joints give, were all others right.

    Attributes:
        course: (T, joints) how much more encoders show than their links' angles [rad].
        compliance: by which they give with their torques [rad/(N m)]; None where they do not.
        spent: logarithm of evidence that it costs: it is fitted to what it then explains.
    """

    course: FloatArray
    compliance: float | None
    spent: float


class Give:
    """By the pose of one sole in the other's, which may not change while both stand.

    Of one joint one number explains six; of more it is the least that does. What it is in a
    segment's mean only tells how flat the soles stand. Each set of joints is worked out once.

    Args:
        samples: T of a session.
        answers: (T, 6, m) of the closure to each joint.
        closure: (T, 6) its residuals [m, rad].
        torque: (T, m) that the joints hold with [N m].
    """

    def __init__(
        self, samples: Samples, answers: FloatArray, closure: FloatArray, torque: FloatArray
    ) -> None:
        self._samples, self._answers = samples, answers
        self._closure, self._torque = closure, torque
        self._told: dict[tuple[int, ...], Given] = {}

    def of(self, joints: Sequence[int]) -> Given:
        """What these joints give."""
        key = tuple(joints)
        if key not in self._told:
            course = self._course(key)
            compliance = self.with_torque(key, course)
            self._told[key] = Given(course, compliance, self._spent(len(key)))
        return self._told[key]

    def _course(self, joints: Sequence[int]) -> FloatArray:
        samples = self._samples
        course = self._least(joints, slice(0, 6))
        level = samples.segment_means(self._least(joints, FLAT_OF_CLOSURE))
        for segment in np.unique(samples.segment):
            here = samples.segment == segment
            own = uniform_filter1d(course[here], self._width, axis=0, mode="nearest")
            course[here] = own - own.mean(axis=0)
        return np.where(samples.both[:, None], course + level, 0.0)

    def _least(self, joints: Sequence[int], part: slice) -> FloatArray:
        """(T, joints) of each sample by a part of the pose alone."""
        weight = np.array([1.0 / LEVER] * 3 + [1.0] * 3)[part]
        answer = self._answers[:, part][:, :, list(joints)] * weight[:, None]
        wandered = self._closure[:, part] * weight
        across = answer.transpose(0, 2, 1)
        normal = across @ answer + LEAST_ANSWER * np.eye(len(joints))
        found = np.linalg.solve(normal, across @ wandered[:, :, None])[:, :, 0]
        return np.where(self._samples.both[:, None], found, 0.0)

    def _spent(self, joints: int) -> float:
        """Each mean that is told costs, of at most as many joints as a pose has numbers."""
        numbers = min(joints, 6) * np.count_nonzero(self._samples.both) / self._width
        return SPENT * numbers

    def with_torque(self, joints: Sequence[int], course: FloatArray) -> float | None:
        """Compliance of joints with a course (T, joints) [rad/(N m)]; None without any."""
        samples = self._samples
        both = samples.both[:, None]
        torque, given = (
            np.where(both, one - samples.segment_means(np.where(both, one, 0.0)), 0.0).ravel()
            for one in (self._torque[:, list(joints)], course)
        )
        across, own, power = given @ torque, given @ given, torque @ torque
        if across <= FOLLOWS * np.sqrt(own * power) or power == 0.0:
            return None
        return float(across / power)

    @property
    def _width(self) -> int:
        """Samples of a mean."""
        samples = self._samples
        step = float(np.median(np.diff(samples.time)[np.diff(samples.segment) == 0]))
        return max(1, round(SMOOTH_S / step))
