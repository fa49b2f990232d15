"""Whether the robot may be moved, as whoever arms it tells the other nodes."""

from __future__ import annotations

from typing import Any

from std_msgs.msg import Bool

from shoecal_ros.common import qos
from shoecal_ros.common.runtime import ShoecalNode


class ArmedInput:
    """The latched `shoe/armed`; it counts only while somebody is there to take it back."""

    def __init__(self, node: ShoecalNode) -> None:
        self._told = False
        self._subscription = node.subscribe(Bool, "shoe/armed", self._hear, qos.LATCHED)

    @property
    def armed(self) -> bool:
        """Whether the robot may be moved at this moment."""
        return self._told and self._subscription.get_publisher_count() > 0

    def _hear(self, messages: list[Any]) -> None:
        self._told = messages[-1].data
