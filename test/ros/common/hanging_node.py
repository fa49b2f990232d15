"""A node whose middleware hangs with Python's lock held, or aborts the process, at its end."""

from __future__ import annotations

import atexit
import ctypes
import os
import sys

from shoecal_ros.common import process
from shoecal_ros.common.health import Level
from shoecal_ros.common.node import ShoecalNode

HOW = sys.argv.pop(1)


class HangingNode(ShoecalNode):
    """Says when it has left the robot safe."""

    def __init__(self) -> None:
        super().__init__("hanging")
        self.log(Level.OK, "begun")

    def close(self) -> None:
        self.log(Level.OK, "robot safe")

    def destroy_node(self) -> None:
        if HOW == "hang":
            ctypes.PyDLL(None).sleep(1000)
        super().destroy_node()


if __name__ == "__main__":
    process.DEADLINE_S = 0.5
    if HOW == "abort":
        atexit.register(os.abort)
    process.run(HangingNode)
