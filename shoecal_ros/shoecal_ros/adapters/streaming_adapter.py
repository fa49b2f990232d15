"""An adapter to a driver that takes one set of joint angles after the other."""

from __future__ import annotations

import time
from abc import abstractmethod
from collections.abc import Sequence

from rclpy.publisher import Publisher

from shoecal_core.arrays import FloatArray
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.adapters.adapter import OLDEST_S, Adapter
from shoecal_ros.adapters.stream import Stream

ASLEEP_S = OLDEST_S
"""A driver that is sent nothing for so long has come to rest at the last set point."""


class StreamingAdapter(Adapter):
    """Samples trajectories at the driver's rate."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._stream = Stream(self.robot)
        self._period_s = 0.0
        self._looked_s = self.now_s

    def send_at(self, rate: float) -> None:
        """Begin to send set points this often [Hz]."""
        self._period_s = 1.0 / rate
        self.wall_timer(self._period_s, self._send)

    @abstractmethod
    def send(self, names: Sequence[str], angles: FloatArray) -> None:
        """Send the driver set points (k,) of joints [rad]."""

    def follow(self, trajectory: JointTrajectory, measured: FloatArray) -> None:
        """Sample it from now on; measured (m,) [rad]."""
        self._catch_up()
        self._stream.begin(trajectory, measured, self.now_s)

    def commanded(self, names: tuple[str, ...]) -> FloatArray | None:
        """(k,) set points [rad]."""
        self._catch_up()
        angles = self._stream.at(self.now_s)
        if angles is None or not set(names) <= set(self._stream.names):
            return None
        chosen: FloatArray = angles[[self._stream.names.index(name) for name in names]]
        return chosen

    def stop(self) -> None:
        """Come to rest smoothly; drivers keep the last set points by themselves."""
        self._catch_up()
        self._stream.stop(self.now_s)

    def close(self) -> None:
        """Leave no robot on its way, on one to hold neither: go on until it has come to rest."""
        self.stop()
        while self.context.ok() and self._stream.active:
            rests = not self._stream.under_way(self.now_s)
            self._send()
            if rests:
                break
            time.sleep(self._period_s)

    def _catch_up(self) -> None:
        """After a sleep of this process the robot rests at the last set point."""
        now_s = self.now_s
        if now_s - self._looked_s > ASLEEP_S:
            self._stream.rest(self._looked_s, now_s)
            self._looked_s = now_s

    def _send(self) -> None:
        self._catch_up()
        self._looked_s = self.now_s
        angles = self._stream.at(self._looked_s)
        if angles is not None:
            self.send(self._stream.names, angles)


def unheard(publisher: Publisher, driver: str) -> str:
    """Message that the driver does not subscribe; empty where it does."""
    if publisher.get_subscription_count() > 0:
        return ""
    return f"no node subscribes to {publisher.topic_name}; start {driver}"
