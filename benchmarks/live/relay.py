"""The bare chain: two nodes that only relay messages, as many hops and as large as shoecal's.

    python relay.py first PORT | python relay.py second

The first one reads the same bytes from a serial port of its own, and looks at none of them but the
delimiter; the second one gets its messages and sends points.
"""

from __future__ import annotations

import os
import select
import sys
import threading
import tty
from functools import partial
from pathlib import Path

import rclpy
from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from shoecal_msgs.msg import ShoeVoltages

from live.spinning import spin
from shoecal_core.shoe.shoe_file import load_shoe
from shoecal_core.workspace import config_dir
from shoecal_ros.common import qos
from shoecal_ros.serial.protocol import DELIMITER

VOLTAGES, COP = "bare/voltages", "bare/cop"
WAIT_S = 0.1


class First(Node):
    """Bytes -> messages of the size of the driver's."""

    def __init__(self, port: Path) -> None:
        super().__init__("bare_first")
        self._publisher = self.create_publisher(ShoeVoltages, VOLTAGES, qos.RAW)
        names = load_shoe(config_dir() / "shoes" / "nao_shoe.yaml").names
        self._message = ShoeVoltages(
            cell=list(names), voltage=[0.001] * len(names), status=[0] * len(names), temperature=1.0
        )
        self._message.header.frame_id = "shoe_driver"
        self._port = os.open(port, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self._port)
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def _read(self) -> None:
        message, count = self._message, 0
        while rclpy.ok():
            if not select.select([self._port], [], [], WAIT_S)[0]:
                continue
            for _ in range(os.read(self._port, 4096).count(DELIMITER)):
                message.sequence = count
                message.header.stamp.nanosec = count
                self._publisher.publish(message)
                count += 1


class Second(Node):
    """Messages -> points."""

    def __init__(self) -> None:
        super().__init__("bare_second")
        self._publisher = self.create_publisher(PointStamped, COP, qos.LIVE)
        self._subscription = self.create_subscription(ShoeVoltages, VOLTAGES, self._hear, qos.RAW)

    def _hear(self, message: ShoeVoltages) -> None:
        point = PointStamped()
        point.header.stamp = message.header.stamp
        point.header.frame_id = "l_sole"
        point.point.x = float(message.sequence)
        self._publisher.publish(point)


def main() -> None:
    spin(partial(First, Path(sys.argv[2])) if sys.argv[1] == "first" else Second)


if __name__ == "__main__":
    main()
