"""What a robot may do unsupervised: the adapter that sent it is gone."""

from __future__ import annotations

import math
import time
from typing import Any

from rclpy.subscription import Subscription
from std_msgs.msg import Bool

from shoecal_ros.common import qos
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.inputs.armed_input import ArmedInput

HISTORY_S = 0.2
"""What was said of arming before a node began is heard within so long, oldest word first."""


class Unwatched:
    """A motion that may be under way since before this node began.

    There may be one where the robot was armed already by then; where it was not, it is somebody
    else's business what it does.
    """

    def __init__(self, node: ShoecalNode, arming: ArmedInput) -> None:
        """Nothing is known yet, of a node that has just begun."""
        self._arming = arming
        self._heard_s = math.inf
        self._disarmings: int | None = None
        self._over = self._replaced = False
        self._subscription: Subscription = node.subscribe(Bool, "shoe/armed", self._hear, qos.ARMED)

    @property
    def judged(self) -> bool:
        """Whether it is known by now if there may be one."""
        return self._over or self._disarmings is not None

    def to_be_stopped(self) -> bool:
        """Whether to stop it now: once as soon as it is supposed, once when it is disarmed."""
        if self._over:
            return False
        if self._disarmings is None:
            if time.monotonic() - self._heard_s < HISTORY_S:
                return False
            self._disarmings = self._arming.disarmings
            self._over = not self._arming.reported
            return not self._over
        self._over = not self._arming.armed or self._arming.disarmings != self._disarmings
        return self._over

    def replace(self) -> None:
        """Another motion takes its place."""
        self._replaced, self._over = not self._over, True

    def come_back(self) -> None:
        """The robot did not take that other one."""
        self._over = self._over and not self._replaced

    def _hear(self, messages: list[Any]) -> None:
        del messages
        self._heard_s = min(self._heard_s, time.monotonic())
