"""Do joint angles come from one sender? Two of the same joints would be mixed, sample by sample."""

from __future__ import annotations

from collections import deque

import numpy as np

from shoecal_core.arrays import BoolArray, FloatArray, IntArray
from shoecal_core.robot.robot import Robot
from shoecal_ros.inputs.joining import CLOCK_SET_NS

SLACK_RAD, SLACK_SPEED = 0.05, 2.0
"""Between two samples a joint moves by no more than this, plus so many times its fastest."""
UNLIMITED_RAD_S = 10.0
"""Fastest speed of a joint whose URDF gives none."""
_STEPS = 50
_ODD = 3
"""More odd samples than this in so many: two senders, or an encoder that fails."""


class OneSender:
    """Lets through what follows from what came before.

    A sample from which no joint could have come here in time, or whose stamp falls far back, is
    believed once the next one confirms it: a robot may have been put elsewhere, a clock may have
    been set. Where that goes to and fro two senders send the same joints, each of itself.
    """

    def __init__(self, robot: Robot) -> None:
        """Nothing has come."""
        limit = robot.velocity_limit
        known = np.isfinite(limit) & (limit > 0.0)
        self._speed = SLACK_SPEED * np.where(known, limit, UNLIMITED_RAD_S)
        self._heard_ns = 0
        self._believed: tuple[int, FloatArray] | None = None
        self._pending: tuple[int, FloatArray] | None = None
        self._odd: deque[bool] = deque(maxlen=_STEPS)

    @property
    def doubled(self) -> bool:
        """Whether stamps or angles run to and fro."""
        return sum(self._odd) > _ODD

    def follows(self, stamps: IntArray, angles: FloatArray) -> BoolArray:
        """(T,) which samples count, of (T,) stamps [ns] and (T, m) angles [rad] as they came."""
        if len(stamps) == 1 or not self._all_follow(stamps, angles):
            return np.array([self._one(*one) for one in zip(stamps.tolist(), angles, strict=True)])
        self._heard_ns = int(stamps[-1])
        self._believed = self._heard_ns, angles[-1]
        self._odd.extend([False] * min(len(stamps), _STEPS))
        return np.ones(len(stamps), dtype=np.bool_)

    def _all_follow(self, stamps: IntArray, angles: FloatArray) -> bool:
        """Nearly always several do, and then it is quickly seen."""
        if self._believed is None or self._pending is not None:
            return False
        stamp, before = self._believed
        steps = np.diff(stamps, prepend=stamp)
        ways = np.abs(np.diff(angles, axis=0, prepend=before[None]))
        near = ways <= SLACK_RAD + self._speed * (steps / 1e9)[:, None]
        return bool((steps > 0).all() and stamps[0] > self._heard_ns and near.all())

    def _one(self, stamp: int, angles: FloatArray) -> bool:
        """Whether one sample counts."""
        back, self._heard_ns = stamp < self._heard_ns, stamp
        believed, jumps = False, False
        if self._believed is None or self._near(self._believed, stamp, angles):
            believed = True
        elif not 0 <= self._believed[0] - stamp < CLOCK_SET_NS:
            believed = self._pending is not None and self._near(self._pending, stamp, angles)
            jumps = not believed
        self._odd.append(back or jumps)
        if believed:
            self._believed, self._pending = (stamp, angles), None
        elif jumps:
            self._pending = stamp, angles
        return believed

    def _near(self, before: tuple[int, FloatArray], stamp: int, angles: FloatArray) -> bool:
        """Whether a sample may follow another one."""
        elapsed_s = (stamp - before[0]) / 1e9
        reach = SLACK_RAD + self._speed * elapsed_s
        return elapsed_s > 0.0 and bool((np.abs(angles - before[1]) <= reach).all())
