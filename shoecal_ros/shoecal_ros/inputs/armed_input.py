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
        self._disarmings = 0
        self._subscription = node.subscribe(Bool, "shoe/armed", self._hear, qos.LATCHED)

    @property
    def armed(self) -> bool:
        """Whether the robot may be moved at this moment."""
        return self._told and self._subscription.get_publisher_count() > 0

    @property
    def disarmings(self) -> int:
        """How often it was taken back: who was allowed to move before is not allowed again."""
        return self._disarmings

    def _hear(self, messages: list[Any]) -> None:
        for message in messages:
            self._disarmings += self._told and not message.data
            self._told = message.data
