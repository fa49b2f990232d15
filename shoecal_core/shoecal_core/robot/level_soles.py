"""How far soles are from level and from standing still on one floor, by the joint angles."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from shoecal_core.arrays import FloatArray, IntArray
from shoecal_core.robot.kinematics import BodyStates, Kinematics

CLOSED_M, CLOSED_RAD = 0.01, float(np.radians(2.0))
"""Soles of a robot whose zeros are right are level to within this: play and sag of its joints."""
SAMPLES = 80
"""Samples of a run that are looked at, evenly over all."""


@dataclass(frozen=True)
class Postures:
    """Joint angles of one run or several, in each of which both feet mostly stay in one place.

    Attributes:
        kinematics: of the robot.
        angles: (T, m) finite [rad].
        run: (T,) index of the run that an instant is of.
    """

    kinematics: Kinematics
    angles: FloatArray
    run: IntArray

    def changed(self, angles: FloatArray) -> Postures:
        """The same instants with other angles (T, m) [rad]."""
        return replace(self, angles=angles)

    @cached_property
    def states(self) -> BodyStates:
        """Of the robot, at T instants."""
        return self.kinematics.states(self.angles)

    @cached_property
    def residuals(self) -> FloatArray:
        """(T, 5): height, tilt, and how far x, y and yaw are off the run's median; in
        tolerances.
        """
        height, tilt = off_level(self.states)
        place = np.column_stack((self.states.translation[:, :2], self.states.yaw))
        for run in np.unique(self.run):
            own = place[self.run == run]
            own[:, 2] = np.unwrap(own[:, 2])
            place[self.run == run] = own - np.median(own, axis=0)
        sizes = (CLOSED_M, CLOSED_RAD, CLOSED_M, CLOSED_M, CLOSED_RAD)
        return np.asarray(np.column_stack((height, tilt, place)) / sizes)

    @property
    def misfit(self) -> float:
        """Mean over all samples of how far the soles are from level and from standing still, in
        tolerances; those in which a foot is lifted count little.
        """
        return float(np.mean(np.log1p(np.sum(self.residuals**2, axis=1))))

    def closed(self, share: float) -> bool:
        """Whether the soles are level and still, at this share of the samples."""
        return bool(np.mean((np.abs(self.residuals) <= 1.0).all(axis=1)) >= share)

    def wander(self) -> float:
        """How far one sole moves against the other in a run, the most [m]."""
        return max(
            float(np.ptp(np.percentile(own, [5.0, 95.0], axis=0), axis=0).max())
            for run in np.unique(self.run)
            for own in (self.states.translation[self.run == run, :2],)
        )


def sampled(kinematics: Kinematics, runs: tuple[FloatArray, ...]) -> Postures:
    """Some instants of every run.

    Args:
        kinematics: of the robot.
        runs: (T, m) finite angles of each, T > 0 [rad].
    """
    chosen = [
        one[np.unique(np.linspace(0, len(one) - 1, SAMPLES).astype(np.int64))] for one in runs
    ]
    run = np.repeat(np.arange(len(runs)), [len(one) for one in chosen])
    return Postures(kinematics, np.concatenate(chosen), run)


def off_level(states: BodyStates) -> tuple[FloatArray, FloatArray]:
    """(T,) height of one sole above the other [m], (T,) tilt between them [rad]."""
    tilt = np.arccos(np.clip(states.rotation[:, 2, 2], -1.0, 1.0))
    return np.abs(states.translation[:, 2]), tilt
