"""Node `shoe_driver`: a serial device's frames as stamped voltages."""

from __future__ import annotations

import threading
import time
from collections import deque
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from rclpy.subscription import Subscription
from shoecal_msgs.msg import ShoeVoltages

from shoecal_core.errors import ShoecalError
from shoecal_core.settings import Settings, setting
from shoecal_core.workspace import config_dir
from shoecal_ros.common import qos
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.conversions import time_from_ros, voltages_to_ros
from shoecal_ros.common.health import Condition
from shoecal_ros.common.names import short_name
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.process import run
from shoecal_ros.common.voltage_frame import VoltageFrame
from shoecal_ros.inputs.voltages import REMEMBER_S
from shoecal_ros.serial.config import load_driver_config
from shoecal_ros.serial.driver import DriverStatus, Reading, open_driver
from shoecal_ros.serial.frame import FaultKind

READ_S = 0.1
"""Longest wait for bytes: bounds how long closing takes."""
OWN_STAMPS = 1000
START_S = 2.0
"""In the beginning nothing is a problem for so long."""


@dataclass(frozen=True)
class ShoeDriverSettings(Settings):
    """Settings of the driver's node; the device itself is described in `config_file`."""

    config_file: str = setting(
        "", "", "device file; empty: the configuration's nodes/shoe_driver.yaml"
    )
    port: str = setting("", "", "serial port; empty: the one in the device file")
    source: str = setting("", "", "frame_id of what is published; empty: the node's full name")


class ShoeDriverNode(ShoecalNode):
    """Reads in a thread of its own and publishes from there: it waits for nothing else here."""

    def __init__(self) -> None:
        super().__init__("shoe_driver")
        settings = self.settings(ShoeDriverSettings)
        file = settings.config_file or config_dir() / "nodes" / "shoe_driver.yaml"
        config = load_driver_config(Path(file))
        if settings.port:
            config = replace(config, port=settings.port)
        self._source = settings.source or self.get_fully_qualified_name().lstrip("/")
        self._cells = {channel.cell for channel in config.channels}
        self._publisher = self.create_publisher(ShoeVoltages, "shoe/voltages", qos.DEVICE)
        self._own: deque[int] = deque(maxlen=OWN_STAMPS)
        self._others: Subscription | None = None
        self._rival: Problem | None = None
        self._rival_at = 0.0
        self._trouble: Problem | None = None
        self._error: Exception | None = None
        self._driver = open_driver(config, lambda: self.now_ns)
        self._patient_until = time.monotonic() + START_S
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def watch(self) -> None:
        """Report the condition of the device, and look for others that send the same cells."""
        if self._error is not None:
            # A node without its reader would look alive.
            raise self._error
        status = self._driver.status()
        if time.monotonic() - self._rival_at > REMEMBER_S:
            self._rival = None
        problem = self._rival or self._trouble or status.problem
        well = f"reading {status.source.name}"
        if problem is not None and time.monotonic() < self._patient_until:
            problem, well = None, f"opening {status.source.name}"
        self.health.note("device", Condition.of(problem, well, _figures(status)))
        self._listen_to_others()
        super().watch()

    def close(self) -> None:
        """Stop reading."""
        self._closing.set()
        self._driver.close()
        self._thread.join()

    def _read(self) -> None:
        try:
            while not self._closing.is_set():
                for reading in self._driver.read(READ_S):
                    self._publish(reading)
        except ShoecalError as error:
            # For instance a log whose lines carry no time: nothing more will come.
            self._trouble = Problem.of(error)
        except Exception as error:  # noqa: BLE001 - `watch` raises it again
            self._error = error

    def _publish(self, reading: Reading) -> None:
        cells = reading.cells
        frame = VoltageFrame(
            stamp_ns=reading.stamp_ns,
            source=self._source,
            sequence=reading.sequence,
            cells=cells.cell,
            voltage=np.array(cells.voltage),
            status=np.array(cells.status, dtype=np.uint8),
            temperature=reading.temperature,
        )
        self._own.append(reading.stamp_ns)
        self._publisher.publish(voltages_to_ros(frame))

    def _listen_to_others(self) -> None:
        """Listen to the own topic only while somebody else publishes there."""
        alone = self.count_publishers(self._publisher.topic_name) < 2
        if alone and self._others is not None:
            self.destroy_subscription(self._others)
            self._others = self._rival = None
        elif not alone and self._others is None:
            self._others = self.subscribe(ShoeVoltages, "shoe/voltages", self._hear, qos.LIVE)

    def _hear(self, messages: list[Any]) -> None:
        own = set(self._own)
        for message in messages:
            common = sorted(self._cells.intersection(message.cell))
            if common and time_from_ros(message.header.stamp) not in own:
                self._rival_at = time.monotonic()
                other = short_name(message.header.frame_id)
                self._rival = Problem(
                    Code.SECOND_DRIVER,
                    f"cell(s) {', '.join(common)} also come from '{other}'; stop one driver, "
                    "or let each send its own cells",
                )


def _figures(status: DriverStatus) -> dict[str, str]:
    source = status.source
    figures: dict[str, object] = {
        "port": source.name,
        "connected": source.connected,
        "rate_hz": f"{source.rate:.1f}",
        "age_s": "never" if source.age is None else f"{source.age:.3f}",
        "lost_frames": source.counts.faults[FaultKind.LOST_FRAMES],
        "frames": source.counts.frames,
        "bytes": source.counts.bytes,
        "skipped_bytes": source.counts.skipped_bytes,
        "reconnects": source.reconnects,
        "clock_drift": f"{status.clock_drift:.2e}",
        "clock_resets": status.clock_resets,
    }
    if source.info is not None:
        figures["firmware"] = source.info.firmware
    figures |= {
        fault.value.replace(" ", "_"): count for fault, count in source.counts.faults.items()
    }
    return {key: str(value) for key, value in figures.items()}


def main() -> None:
    """Run the node."""
    run(ShoeDriverNode)


if __name__ == "__main__":
    main()
