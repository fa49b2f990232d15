"""Where the right foot stands relative to the left."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import ShoecalError

FARTHEST_M = 100.0
"""Beyond that geometry is rounding."""
NEAR_M, NEAR_RAD = 0.01, 0.02
"""Double supports that are nearer to each other count as one."""


@dataclass(frozen=True)
class DoubleSupport:
    """Pose of the right sole in the left sole's frame, both on one level floor.

    Attributes:
        dx: forward [m].
        dy: to the left [m]; negative where the right foot stands on the right.
        dtheta: counter-clockwise [rad].
    """

    dx: float
    dy: float
    dtheta: float

    def __post_init__(self) -> None:
        text = f"dx {self.dx:g}, dy {self.dy:g}, dtheta {self.dtheta:g}"
        if not all(math.isfinite(value) for value in (self.dx, self.dy, self.dtheta)):
            raise ShoecalError(f"{text}: dx, dy and dtheta must be finite numbers")
        if max(abs(self.dx), abs(self.dy)) > FARTHEST_M:
            raise ShoecalError(f"{text}: dx and dy are metres; no foot is {FARTHEST_M:g} m away")
        if abs(self.dtheta) > math.tau:
            raise ShoecalError(f"{text}: dtheta is in radians; give it within one turn")

    def __str__(self) -> str:
        return (
            f"dx {self.dx:g} m, dy {self.dy:g} m, dtheta {self.dtheta:g} rad "
            f"({math.degrees(self.dtheta):.0f} deg)"
        )

    @property
    def rotation(self) -> FloatArray:
        """(2, 2) turns vectors of the right sole's frame into the left's."""
        c, s = math.cos(self.dtheta), math.sin(self.dtheta)
        return np.array([[c, -s], [s, c]])

    @property
    def translation(self) -> FloatArray:
        """(2,) origin of the right sole in the left sole's frame [m]."""
        return np.array([self.dx, self.dy])

    def right_to_left(self, points: FloatArray) -> FloatArray:
        """Points (..., 2) of the right sole's frame in the left sole's frame [m]."""
        return points @ self.rotation.T + self.translation

    def left_to_right(self, points: FloatArray) -> FloatArray:
        """Points (..., 2) of the left sole's frame in the right sole's frame [m]."""
        return (points - self.translation) @ self.rotation


def count_distinct(supports: Iterable[DoubleSupport]) -> int:
    """How many double supports there are, those that nearly coincide taken as one."""
    found: list[DoubleSupport] = []
    for one in supports:
        if not any(_near(one, other) for other in found):
            found.append(one)
    return len(found)


def _near(one: DoubleSupport, other: DoubleSupport) -> bool:
    away = math.hypot(one.dx - other.dx, one.dy - other.dy)
    turned = math.remainder(one.dtheta - other.dtheta, math.tau)
    return away < NEAR_M and abs(turned) < NEAR_RAD
