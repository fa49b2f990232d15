"""Voltages as lines of JSON on standard output, for programs without ROS.

    python -m shoecal_ros.voltage_stream --ros-args -p shoe_file:=…

One line an instant: `{"stamp_ns": …, "cells": […], "voltages": […], "status": […]}` with all cells
of the shoe; null where one gave none. While none come: `{"problem": "…"}`, once for each cause.
It ends on an interrupt, and when its output is not read any more.
"""

from __future__ import annotations

import json
import os
import select
import string
import sys
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from rclpy.executors import ExternalShutdownException
from shoecal_msgs.msg import ShoeVoltages

from shoecal_core.errors import ShoecalError
from shoecal_core.settings import setting
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Problem
from shoecal_ros.common.conversions import voltages_from_ros
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.process import run
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.inputs.joining import NO_DATA, FrameJoiner, Joined, JoinSettings
from shoecal_ros.inputs.voltages import VoltageInput

_NO_DIGITS = str.maketrans("", "", string.digits)


@dataclass(frozen=True)
class StreamSettings(JoinSettings):
    """Of the stream alone."""

    stale_s: float = setting(2.0, "s", "without voltages for that long it says so", minimum=0.01)


class VoltageStream(ShoecalNode):
    """Prints what the driver publishes."""

    def __init__(self) -> None:
        super().__init__("voltage_stream")
        settings = self.settings(StreamSettings)
        shoe = self.settings(RobotFiles).load_shoe()
        self._cells = list(shoe.names)
        self._input = VoltageInput(FrameJoiner(shoe.names, settings.hold_s), settings.stale_s)
        self._patient_until = time.monotonic() + settings.stale_s
        self._reported = ""
        self._output = select.poll()
        self._output.register(sys.stdout, 0)  # errors alone: that its reader is gone
        self.subscribe(ShoeVoltages, "shoe/voltages", self._hear, qos.LIVE)

    def watch(self) -> None:
        """Report what is wrong with the voltages; end with their reader."""
        if self._output.poll(0):
            raise ExternalShutdownException
        problem = self._input.problem
        # For how many seconds already is no news.
        cause = "" if problem is None else problem.message.translate(_NO_DIGITS)
        if cause != self._reported and time.monotonic() > self._patient_until:
            self._reported = cause
            if problem is not None:
                _print({"problem": problem.message})
        self.health.note("voltages", self._input.condition)
        super().watch()

    def _hear(self, messages: list[Any]) -> None:
        for message in messages:
            try:
                frame = voltages_from_ros(message)
            except ShoecalError as error:
                self._input.refuse(Problem.of(error))
                continue
            for joined in self._input.take([frame]):
                _print(self._line(joined))

    def _line(self, joined: Joined) -> dict[str, object]:
        known = np.isfinite(joined.readings)
        reported = zip(joined.readings.tolist(), known, strict=True)
        return {
            "stamp_ns": joined.stamp_ns,
            "cells": self._cells,
            "voltages": [value if finite else None for value, finite in reported],
            "status": np.where(known | (joined.status > 0), joined.status, NO_DATA).tolist(),
        }


def _print(line: dict[str, object]) -> None:
    try:
        print(json.dumps(line, allow_nan=False), flush=True)
    except BrokenPipeError as error:
        # The interpreter would flush once more at its end.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise ExternalShutdownException from error


def main() -> None:
    """Run the node."""
    run(VoltageStream)


if __name__ == "__main__":
    main()
