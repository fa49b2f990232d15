"""An adapter to a driver that takes one set of joint angles after the other."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence

from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_ros.adapters.adapter import Adapter, FloatArray
from shoecal_ros.adapters.stream import Stream


class StreamingAdapter(Adapter):
    """Samples trajectories at the driver's rate."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._stream = Stream(self.robot)

    def send_at(self, rate: float) -> None:
        """Begin to send set points this often [Hz]."""
        self.wall_timer(1.0 / rate, self._send)

    @abstractmethod
    def send(self, names: Sequence[str], angles: FloatArray) -> None:
        """Tell the driver set points (k,) of joints [rad]."""

    def follow(self, trajectory: JointTrajectory, measured: FloatArray) -> None:
        """Sample it from now on."""
        self._stream.begin(trajectory, measured, self.now_s)

    def stop(self) -> None:
        """Stay at the last set points, which drivers keep by themselves."""
        if self._stream.under_way(self.now_s):
            self._stream.stop(self.now_s)
            self._send()

    def _send(self) -> None:
        angles = self._stream.at(self.now_s)
        if angles is not None:
            self.send(self._stream.names, angles)
