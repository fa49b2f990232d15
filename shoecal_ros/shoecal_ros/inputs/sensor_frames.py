"""Messages of force channels, whatever topic they come on, as frames of readings."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from geometry_msgs.msg import WrenchStamped

from shoecal_core.recording import schemas
from shoecal_core.shoe.shoe import AXES, FEET, Shoe
from shoecal_ros.common.conversions import time_from_ros, voltages_from_ros
from shoecal_ros.common.voltage_frame import VoltageFrame


def frame_reader(topic: str, shoe: Shoe) -> Callable[[Any], VoltageFrame] | None:
    """What turns a topic's messages into frames; None where it carries no channel of the shoe."""
    if topic == schemas.VOLTAGES:
        return voltages_from_ros
    for foot, name in zip(FEET, schemas.FORCE_TORQUE, strict=True):
        axes = [axis for axis in AXES if f"{foot}/{axis}" in shoe.names]
        if topic == name and axes:
            return _WrenchReader(foot, axes)
    return None


class _WrenchReader:
    """A six-axis sensor has no counter: its messages are counted here."""

    def __init__(self, foot: str, axes: list[str]) -> None:
        self._source = f"ft/{foot}"
        self._cells = tuple(f"{foot}/{axis}" for axis in axes)
        self._axes = axes
        self._count = 0

    def __call__(self, message: WrenchStamped) -> VoltageFrame:
        """One message as a frame."""
        self._count = (self._count + 1) % 2**32
        wrench = message.wrench
        values = [
            getattr(wrench.force if axis.startswith("f") else wrench.torque, axis[1])
            for axis in self._axes
        ]
        return VoltageFrame(
            stamp_ns=time_from_ros(message.header.stamp),
            source=self._source,
            sequence=self._count,
            cells=self._cells,
            voltage=np.array(values),
            status=np.where(np.isfinite(values), 0, schemas.NO_DATA).astype(np.uint8),
        )
