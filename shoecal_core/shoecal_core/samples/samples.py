"""A session as a diagnosis sees it: a few samples a second, cut where feet come and go.

Filters, delays and derivatives are worked out at the recorded rate; `Track.mean` then brings
their results to the samples.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_core.robot.kinematics import BodyStates
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.filters import play
from shoecal_core.shoe.shoe import Shoe

STRETCH_S = 6.0
TURNED_BACK = 0.004
"""rad; a joint that has moved back by this is dragged to the other side."""


@dataclass(frozen=True)
class Track:
    """One run at the rate of its readings, F of them.

    Attributes:
        run: its number. motion: what it did. walks: it names no double support: feet move.
        start: of the run since the session's first sample [s].
        time: (F,) since the run's start [s].
        readings: (F, n) raw.
        angles: (F, m) as recorded [rad].
        efforts: (F, m) of the joints [N m]; None where none were recorded.
        up: (F, 3) the direction upwards in the base's frame; None without an IMU.
        temperature: (F,) of the shoes [degC]; None where none was recorded.
        com: (F, 2, 3) in the left and right sole's frame [m].
        samples: slice of the samples of the whole session that are made from it.
        weights: (T_run, F) averages over each sample's time.
    """

    run: int
    motion: str
    walks: bool
    start: float
    time: FloatArray
    readings: FloatArray
    angles: FloatArray
    efforts: FloatArray | None
    up: FloatArray | None
    temperature: FloatArray | None
    com: FloatArray
    samples: slice
    weights: csr_matrix

    def mean(self, values: FloatArray) -> FloatArray:
        """(T_run, ...) samples of values (F, ...)."""
        flat = values.reshape(len(values), -1)
        means: FloatArray = np.asarray(self.weights @ flat).reshape(-1, *values.shape[1:])
        return means


@dataclass(frozen=True)
class Samples:
    """T samples of a session in time, with what a fit needs of each.

    Attributes:
        robot, shoe: what it was recorded with.
        tracks: its runs.
        run: (T,) numbers. time: (T,) since the run's start; clock: since the session's [s].
        segment: (T,) number of the stretch in which no foot moves.
        loaded: (T, 2) which feet carry load.
        readings: (T, n). angles: (T, m) [rad].
        states: what the angles say.
        up: (T, 3) upwards in the base's frame, NaN without an IMU.
        force: (T,) expected vertical force [N].
        cop: (T, 2) modelled CoP in the frame of the stance: the left sole's, or the right
            sole's while the left foot hangs [m].
        walks: (T,) force and CoP are the zero-moment point's, not those of a slow motion.
        acceleration: (T, 3) of the CoM in that frame; zero where it walks [m/s^2].
        spin: (T, 2) what the angular momentum adds to that of a single mass [m].
        notes: what is missing or was left out, in words.
    """

    robot: Robot
    shoe: Shoe
    tracks: tuple[Track, ...]
    run: IntArray
    time: FloatArray
    clock: FloatArray
    segment: IntArray
    loaded: BoolArray
    readings: FloatArray
    angles: FloatArray
    states: BodyStates
    up: FloatArray
    force: FloatArray
    cop: FloatArray
    walks: BoolArray
    acceleration: FloatArray
    spin: FloatArray
    notes: tuple[str, ...]

    @property
    def frame(self) -> IntArray:
        """(T,) foot (0 or 1) whose sole frame a sample is in: the right while the left hangs."""
        return np.where(self.loaded[:, 0], 0, 1)

    @cached_property
    def both(self) -> BoolArray:
        """(T,) samples in which both feet stand."""
        standing: BoolArray = self.loaded[:, 0] & self.loaded[:, 1]
        return standing

    @cached_property
    def supports(self) -> tuple[DoubleSupport, ...]:
        """Where the right foot stands in each segment, from the joints."""
        found = []
        for one in range(int(self.segment.max()) + 1):
            part = self.segment == one
            dx, dy = np.median(self.states.translation[part, :2], axis=0)
            yaw = float(np.median(self.states.yaw[part]))
            found.append(DoubleSupport(float(dx), float(dy), yaw))
        return tuple(found)

    @cached_property
    def standing(self) -> tuple[tuple[bool, bool], ...]:
        """Which feet stand in each segment."""
        first = [int(np.argmax(self.segment == one)) for one in range(int(self.segment.max()) + 1)]
        return tuple((bool(self.loaded[at, 0]), bool(self.loaded[at, 1])) for at in first)

    @cached_property
    def stretch(self) -> IntArray:
        """(T,) number of the stretch of time in which errors are alike."""
        stretch = np.stack((self.run, np.floor(self.time / STRETCH_S).astype(np.int64)), axis=1)
        return np.asarray(np.unique(stretch, axis=0, return_inverse=True)[1]).reshape(-1)

    @property
    def runs(self) -> tuple[int, ...]:
        """Numbers of the runs."""
        return tuple(track.run for track in self.tracks)

    @cached_property
    def encoder_step(self) -> FloatArray:
        """(m,) smallest steps of the joints' angles; their scatter where they have none [rad].

        Zero where a robot only walks: there it drowns in the dynamics.
        """
        slow = [track.angles for track in self.tracks if not track.walks]
        if not slow:
            return np.zeros(self.angles.shape[1])
        return np.array([_step(joint) for joint in np.concatenate(slow).T])

    @cached_property
    def efforts(self) -> FloatArray | None:
        """(T, m) of the joints [N m]; None where a run has none."""
        if any(track.efforts is None for track in self.tracks):
            return None
        return self.decimated(lambda track: np.asarray(track.efforts))

    @cached_property
    def dragged(self) -> FloatArray:
        """(T, m) on which side each joint is by the way that it came, from -1/2 to 1/2."""
        width = np.full(self.angles.shape[1], TURNED_BACK)
        return self.decimated(
            lambda track: (track.angles - play(track.angles, width)) / TURNED_BACK
        )

    def segment_means(self, values: FloatArray) -> FloatArray:
        """(T, ...) each sample's segment's mean."""
        segment = self.segment
        count = np.maximum(np.bincount(segment), 1)
        flat = values.reshape(len(values), -1)
        sums = np.stack([np.bincount(segment, weights=column) for column in flat.T], axis=1)
        means: FloatArray = (sums / count[:, None])[segment].reshape(values.shape)
        return means

    def segment_medians(self, values: FloatArray) -> FloatArray:
        """(T, k) of values (T, k): each sample's segment's median."""
        segment = self.segment
        found = np.zeros((int(segment.max()) + 1, values.shape[1]))
        for one in np.unique(segment):
            found[one] = np.median(values[segment == one], axis=0)
        return found[segment]

    def decimated(self, work: Callable[[Track], FloatArray]) -> FloatArray:
        """(T, ...) of what is worked out on each run at the recorded rate (F, ...)."""
        return np.concatenate([track.mean(work(track)) for track in self.tracks])


def _step(values: FloatArray) -> float:
    """Of a quantised angle; for a continuous one the width that has the same scatter."""
    distinct = np.unique(values)
    if len(distinct) < 2:
        return 0.0
    if len(distinct) < 0.2 * len(values):
        return float(np.median(np.diff(distinct)))
    jitter = np.diff(values, n=2) / np.sqrt(6.0)
    return float(np.sqrt(12.0) * 1.4826 * np.median(np.abs(jitter)))
