"""The simulated robot on ROS time: in batches, and re-placed without turning time back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.simulation.converter import ConvertedReadings
from shoecal_core.simulation.floor import FloorTruth
from shoecal_core.simulation.joint_sensors import JointReadings
from shoecal_core.simulation.robot import SimulatedRobot
from shoecal_core.simulation.snapshot import stack

SECOND_NS = 1_000_000_000

START_NS = SECOND_NS
"""Time at the start: 0 means unset in ROS."""
REST_SPEED, REST_S = 2e-3, 0.5
"""m/s, rad/s: slower than this, for that long [s], is at rest."""


@dataclass(frozen=True)
class BodySamples:
    """T samples of everything.

    Attributes:
        stamp_ns: (T,) times of sampling [ns].
        joints, readings, truth: arrays (T, ...).
        orientation: (T, 4) of the torso over the floor: x, y, z, w.
    """

    stamp_ns: IntArray
    joints: JointReadings
    readings: ConvertedReadings
    truth: FloorTruth
    orientation: FloatArray


class Pacer:
    """How many samples are due: simulated time runs with the wall clock, times a factor.

    Time that could not be kept up with is not made up for later.
    """

    def __init__(self, speed: float, rate: float, most: int, now_s: float) -> None:
        """Start at a wall-clock time.

        Args:
            speed: simulated over wall-clock time.
            rate: samples a simulated second [Hz].
            most: samples at once.
            now_s: monotonic [s].
        """
        self._per_second = speed * rate
        self._most = most
        self._seen_s = now_s
        self._owed = 0.0

    def due(self, now_s: float) -> int:
        """Samples due at a wall-clock time."""
        self._owed += (now_s - self._seen_s) * self._per_second
        self._seen_s = now_s
        count = min(int(self._owed), self._most)
        self._owed = min(self._owed - count, 1.0)
        return count


class SimulatedBody:
    """A simulated robot, sampled at a rate.

    Attributes:
        robot: the simulation.
        rate: samples a second [Hz].
    """

    def __init__(self, robot: SimulatedRobot, rate: float) -> None:
        self.robot = robot
        self.rate = rate
        self._base_ns = START_NS
        self._taken = 0
        self._still_since = 0.0

    @property
    def now_ns(self) -> int:
        """Stamp of the last sample [ns]."""
        return self.stamp_ns(self._taken)

    def stamp_ns(self, sample: int) -> int:
        """Stamp of a sample since the robot was last placed [ns]."""
        return self._base_ns + round(sample * SECOND_NS / self.rate)

    def after(self, count: int) -> int:
        """Stamp of the sample that comes last of the next `count` [ns]."""
        return self.stamp_ns(self._taken + count)

    def advance(self, count: int) -> BodySamples:
        """Run on for `count` samples, at least one."""
        first = self._taken + 1
        snapshots = []
        for sample in range(first, first + count):
            self.robot.step_to(sample / self.rate)
            snapshots.append(self.robot.snapshot())
            if np.abs(self.robot.data.qvel).max() > REST_SPEED:
                self._still_since = self.robot.time
        self._taken += count
        together = stack(snapshots)
        stamps = [self.stamp_ns(sample) for sample in range(first, first + count)]
        return BodySamples(
            np.array(stamps, dtype=np.int64),
            self.robot.joints(together),
            self.robot.readings(together),
            self.robot.truth(together),
            together.base_orientation,
        )

    def place(self, joint_angles: FloatArray) -> None:
        """Put the robot down with these joint angles (m,) [rad]; it has yet to settle.

        With this the session's next run begins, as effects count runs.

        Raises:
            SupportNotReachedError: when they do not put both soles on one plane.
        """
        now_ns = self.now_ns
        self.robot.reset(joint_angles)
        self.robot.begin_run()
        self._base_ns, self._taken, self._still_since = now_ns, 0, 0.0

    @property
    def since_placed(self) -> float:
        """Simulated time since the robot was last placed [s]."""
        return self._taken / self.rate

    @property
    def rested(self) -> float:
        """Time at rest over the time that counts as standing still, at most 1."""
        return min(1.0, (self.robot.time - self._still_since) / REST_S)
