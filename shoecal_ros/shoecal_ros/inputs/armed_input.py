"""Whether the robot may be moved, as published by the node that arms it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from std_msgs.msg import Bool

from shoecal_ros.common import qos
from shoecal_ros.common.node import ShoecalNode

LEASE_S = 2.0
"""Who says again and again that the robot is armed has gone when it does not for that long."""
SHORT_LEASE_S = 0.4
"""The same, for who would let a robot go on otherwise."""


class ArmedInput:
    """The latched `shoe/armed`; it counts only while somebody is there to take it back.

    The middleware takes long to find out that a process was killed. So the planner repeats what it
    said while the robot is armed, and that lapses when it falls silent.

    Attributes:
        heard: whether anybody has said so or otherwise.
        reported: whether the last word was that it may, be who said it still there or not.
        disarmings: how often it was taken back: who might move before may not do so again.
    """

    def __init__(
        self,
        node: ShoecalNode,
        clock: Callable[[], float] | None = None,
        lease_s: float = LEASE_S,
    ) -> None:
        self.heard = self.reported = self._repeats = False
        self.disarmings = 0
        # After a sleep of this process the messages of others still wait to be heard.
        self._clock = clock or node.awake
        self._lease_s = lease_s
        self._heard_at = 0.0
        self._subscription = node.subscribe(Bool, "shoe/armed", self._hear, qos.ARMED)

    @property
    def armed(self) -> bool:
        """Whether the robot may be moved at this moment."""
        return self.reported and not self.lapsed

    @property
    def lapsed(self) -> bool:
        """Whether who armed the robot is gone: left, or fallen silent after repeating it."""
        if not self.reported:
            return False
        silent = self._repeats and self._clock() - self._heard_at > self._lease_s
        return silent or self._subscription.get_publisher_count() == 0

    def _hear(self, messages: list[Any]) -> None:
        for message in messages:
            self.disarmings += self.reported and not message.data
            self._repeats = message.data and (self.reported or self._repeats)
            self.heard, self.reported = True, message.data
            self._heard_at = self._clock()
