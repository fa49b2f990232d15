"""Motor temperatures as they come, by joint."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Sequence
from typing import Any

from shoecal_core.robot.robot import Robot

KEEP_S = 30.0
"""Wall-clock time for which a temperature counts: motors warm up in minutes."""
_KEY = "temperature"


class TemperatureInput:
    """What a robot reports of its motors."""

    def __init__(self, robot: Robot, clock: Callable[[], float] = time.monotonic) -> None:
        """Nothing heard.

        Args:
            robot: whose joints; others do not count.
            clock: monotonic [s].
        """
        self._joints = frozenset(robot.joint_names)
        self._clock = clock
        self._heard: dict[str, tuple[float, float]] = {}

    @property
    def degc(self) -> dict[str, float]:
        """By joint, those that came lately [degC]."""
        since = self._clock() - KEEP_S
        return {joint: degc for joint, (degc, heard) in self._heard.items() if heard >= since}

    @property
    def ages(self) -> dict[str, float]:
        """By joint that has ever reported its temperature, since when it has not [s]."""
        now = self._clock()
        return {joint: now - heard for joint, (_, heard) in self._heard.items()}

    def take(self, messages: Sequence[Any]) -> None:
        """Take sensor_msgs/Temperature, one a motor: the frame is the joint's name."""
        for message in messages:
            self._note(message.header.frame_id, message.temperature)

    def take_diagnostics(self, messages: Sequence[Any]) -> None:
        """Take diagnostics: a status whose hardware is a joint may hold its `Temperature`."""
        for message in messages:
            for status in message.status:
                if status.hardware_id not in self._joints:
                    continue
                for pair in status.values:
                    if pair.key.lower() == _KEY:
                        with contextlib.suppress(ValueError):
                            self._note(status.hardware_id, float(pair.value))

    def _note(self, joint: str, degc: float) -> None:
        if joint in self._joints and math.isfinite(degc):
            self._heard[joint] = (degc, self._clock())
