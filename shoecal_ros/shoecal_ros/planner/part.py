"""One trajectory that the robot was sent, and how far it is seen to be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shoecal_core.planning.motion import Motion
from shoecal_ros.inputs.joints import JointBatch
from shoecal_ros.planner.following import Follower
from shoecal_ros.planner.stop_reason import StopReason

FloatArray = NDArray[np.float64]


@dataclass
class StreamedPart:
    """A trajectory that the robot is on.

    Attributes:
        motion: as planned.
        follower: compares joint angles with it.
        seen: the newest joint angles.
        waiting: why it stops as soon as both feet carry.
    """

    motion: Motion
    follower: Follower
    seen: JointBatch
    waiting: StopReason | None = None

    @property
    def stamp_ns(self) -> int:
        """Of the newest joint angles."""
        return int(self.seen.stamp_ns[0])

    @property
    def angles(self) -> FloatArray:
        """(m,) measured [rad]."""
        angles: FloatArray = self.seen.angles[0]
        return angles

    @property
    def at_rest(self) -> FloatArray:
        """(m,) where the robot stops if it has to by then [rad]."""
        return self.follower.at_rest(self.angles)

    @property
    def expected(self) -> FloatArray:
        """(m,) where the robot should be by then [rad]."""
        return self.follower.expected(self.stamp_ns)

    def landmark(self, progress: float) -> int:
        """The landmark pursued at a part of the motion's time."""
        path = self.motion.path
        return int(np.searchsorted(path.switches, progress * len(path.states)))
