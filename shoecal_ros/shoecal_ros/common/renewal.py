"""A trajectory in short pieces, each of which ends at rest.

Who follows a trajectory follows it to its end, whatever has become of who sent it. So no more is
ever sent than the next half a second of it, slowing down to rest along its path; and while all is
well the next piece comes before that slowing down has begun. A robot whose sender is killed, hangs,
or is cut off rests half a second after the last piece, without anything that has to notice.
"""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass, replace

import numpy as np

from shoecal_core.robot.joint_trajectory import JointTrajectory

TIMEOUT_S = 0.5
"""From the beginning of a piece to rest."""
_BRAKE = 0.4
"""Share of a piece in which it slows down. At a real robot 0.2 s: at the planner's largest
`joint_speed` that takes 0.75 rad/s^2, hardly more than its motions do (`joint_acceleration`)."""
_RENEWED = 0.2
"""Share after which the next piece is due: one that is late, or two that are lost, slow nothing."""
_POINT_S = 0.05
"""Between the points of a piece: the cubics between them miss a planned motion by 1e-5 rad."""
_SHORTEST_S = 1e-3
"""Points that would be nearer to each other are one."""


@dataclass(frozen=True)
class _Knot:
    """Between knots the rate changes evenly: time [s], path time [s] and its rate."""

    time: float
    path: float
    rate: float

    def after(self, duration: float, rate: float) -> _Knot:
        """The knot that comes after a duration [s], by then at a rate."""
        path = self.path + 0.5 * (self.rate + rate) * duration
        return _Knot(self.time + duration, path, rate)


class Renewal:
    """One trajectory on its way to a robot.

    Its path time passes at a rate of 1 while pieces come in time, and the rate changes evenly
    otherwise, so that speeds never jump: where a piece comes late the robot has begun to slow down,
    and speeds up from there.

    Attributes:
        trajectory: of k joints.
        begun: when the last piece began; minus infinity before the first [s].
        timeout_s: from then to rest [s].
        done: whether its end has been handed out.
    """

    def __init__(self, trajectory: JointTrajectory) -> None:
        """It begins at time 0.

        Args:
            trajectory: with a point at time 0.
        """
        self.trajectory = trajectory
        self.begun = -np.inf
        self.timeout_s = TIMEOUT_S
        self.done = False
        self._knots = [_Knot(0.0, 0.0, 1.0)]
        self._before = (self.begun, self.timeout_s, self._knots)

    def due(self, time: float) -> bool:
        """Whether the next piece is to be sent at a time [s]."""
        return not self.done and time - self.begun >= _RENEWED * self.timeout_s

    def path_time(self, time: float) -> float:
        """Time on the trajectory [s] at which the robot is commanded to be at a time [s]."""
        return min(self._state(time).path, self.trajectory.duration)

    def motion_time(self, time: float) -> float:
        """The same, but going on after the end [s]."""
        rested_s = time - self._knots[-1].time if self.done else 0.0
        return self.path_time(time) + max(0.0, rested_s)

    def piece(self, time: float, timeout_s: float = TIMEOUT_S) -> JointTrajectory:
        """The next piece, which begins at a time [s] and ends at rest `timeout_s` later at most."""
        begin = self._state(time)
        # Until the first piece it rests where it begins.
        earlier = [knot for knot in self._knots if knot.time < time and self.begun > -np.inf]
        self._before = (self.begun, self.timeout_s, self._knots)
        self.begun, self.timeout_s = time, timeout_s
        brake_s = _BRAKE * timeout_s
        cruising = begin.after((1.0 - begin.rate) * brake_s, 1.0)
        left_s = max(0.0, self.trajectory.duration - cruising.path)
        brake_at = time + timeout_s - brake_s
        if cruising.time + left_s <= time + timeout_s:
            # The trajectory comes to rest by itself.
            # Exactly at its end: one rounding short of it a robot would never arrive.
            end = replace(cruising.after(left_s, 1.0), path=self.trajectory.duration)
            coming = [begin, cruising, end]
            self.done = True
        else:
            braking = cruising.after(brake_at - cruising.time, 1.0)
            coming = [begin, cruising, braking, braking.after(brake_s, 0.0)]
        self._knots = earlier + coming
        return self._sampled([knot.time for knot in coming])

    def take_back(self) -> None:
        """The last piece was not sent."""
        self.begun, self.timeout_s, self._knots = self._before
        self.done = False

    def stopped(self, time: float, stop_s: float) -> float:
        """Path time at which it rests if it slows down evenly from a time on, within stop_s [s]."""
        return self._state(time).after(stop_s, 0.0).path

    def _state(self, time: float) -> _Knot:
        """Path time and rate at a time [s]."""
        index = bisect_right(self._knots, time, key=lambda knot: knot.time) - 1
        if index < 0:
            return _Knot(time, 0.0, 0.0)
        knot = self._knots[index]
        if index + 1 == len(self._knots):
            going = time == knot.time or np.isinf(self.begun)
            return _Knot(time, knot.path, knot.rate if going else 0.0)
        following = self._knots[index + 1]
        share = (time - knot.time) / (following.time - knot.time)
        return knot.after(time - knot.time, knot.rate + share * (following.rate - knot.rate))

    def _sampled(self, knots: list[float]) -> JointTrajectory:
        """From the first of some times [s] to the last, with a point at each of them."""
        times = [knots[0]]
        for end in knots[1:]:
            if end - times[-1] >= _SHORTEST_S:
                count = int(np.ceil((end - times[-1]) / _POINT_S))
                times += np.linspace(times[-1], end, count + 1)[1:].tolist()
        states = [self._state(time) for time in times]
        path = np.array([state.path for state in states])
        rate = np.array([state.rate for state in states])
        # Rounding must leave no speed at the end: controllers refuse that.
        path[-1], rate[-1] = self._state(knots[-1]).path, 0.0
        return JointTrajectory(
            self.trajectory.names,
            np.array(times) - knots[0],
            self.trajectory.at(path),
            rate[:, None] * self.trajectory.rates(path),
        )
