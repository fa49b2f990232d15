"""One trajectory that the robot was sent, and how far it is seen to be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray
from shoecal_core.planning.motion import Motion
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common.renewal import Renewal
from shoecal_ros.inputs.joints import JointBatch
from shoecal_ros.planner.following import Follower
from shoecal_ros.planner.stop_reason import StopReason


@dataclass
class StreamedPart:
    """A trajectory that the robot is on.

    Attributes:
        motion: as planned.
        planned: the same motion of all joints.
        renewal: hands it out piece by piece.
        follower: compares joint angles with it.
        seen: the newest joint angles.
        waiting: why it stops as soon as both feet carry.
        sent_s: when the last piece was sent, by the wall clock [s].
    """

    motion: Motion
    planned: JointTrajectory
    renewal: Renewal
    follower: Follower
    seen: JointBatch
    waiting: StopReason | None = None
    sent_s: float = 0.0

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
    def elapsed(self) -> float:
        """From its begin to the newest joint angles, by the robot's time [s]."""
        return self.follower.elapsed(self.stamp_ns)

    def landmark(self, progress: float) -> int:
        """The landmark pursued at a part of the motion's time."""
        path = self.motion.path
        return int(np.searchsorted(path.switches, progress * len(path.states)))
