"""The subscriber at the end of both chains: notes when each point came.

    python listener.py FILE.npz

Arrays of the file, `shoecal` and `bare`: (m, 2) monotonic clock [ns] and x [m or number].
"""

from __future__ import annotations

import sys
import time
from functools import partial
from pathlib import Path

import numpy as np
from geometry_msgs.msg import PointStamped
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy

from live.relay import COP
from live.spinning import spin

DEEP = QoSProfile(depth=1000, reliability=ReliabilityPolicy.RELIABLE)
"""What is heard late counts as late, not as lost."""


class Listener(Node):
    """Hears the ends of both chains."""

    def __init__(self) -> None:
        super().__init__("listener")
        self.shoecal: list[tuple[int, float]] = []
        self.bare: list[tuple[int, float]] = []
        for topic, heard in (("shoe/cop", self.shoecal), (COP, self.bare)):
            self.create_subscription(PointStamped, topic, partial(_note, heard), DEEP)


def _note(heard: list[tuple[int, float]], message: PointStamped) -> None:
    heard.append((time.monotonic_ns(), message.point.x))


def main() -> None:
    node = spin(Listener)
    assert isinstance(node, Listener)
    np.savez(Path(sys.argv[1]), shoecal=np.array(node.shoecal), bare=np.array(node.bare))


if __name__ == "__main__":
    main()
