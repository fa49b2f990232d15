"""Is anybody there to follow what is sent to the robot?"""

from __future__ import annotations

from rclpy.node import Node
from rclpy.publisher import Publisher

from shoecal_ros.common.codes import Code
from shoecal_ros.common.graph_monitor import node_name
from shoecal_ros.common.health import Condition, Level

RECORDER = "calibrator"
"""Node that listens only to record what is sent."""


class Listeners:
    """Of the topic of commands.

    Attributes:
        missing: what is wrong and its cure; empty where there is somebody.
    """

    def __init__(self, node: Node, publisher: Publisher) -> None:
        """No subscriber has been looked for yet."""
        self._node = node
        self._publisher = publisher
        self._names: list[str] = []
        self.missing = ""
        self.look()

    def look(self) -> None:
        """Look who is there: once in a while, for it takes longer than a message."""
        topic = self._publisher.topic_name
        infos = self._node.get_subscriptions_info_by_topic(topic)
        names = {node_name(info) for info in infos if info.node_name != RECORDER}
        heard = self._publisher.get_subscription_count() > 0
        self._names = sorted(names) if heard else []
        self.missing = (
            "" if self._names else f"no node subscribes to {topic}; start the driver or adapter"
        )

    def condition(self, *, armed: bool) -> Condition:
        """For diagnostics; a missing subscriber matters where the robot may move."""
        if self.missing and armed:
            return Condition(Level.WARN, self.missing, code=Code.NOBODY_LISTENS)
        if self.missing:
            return Condition(Level.OK, self.missing)
        reported = ", ".join(f"'{name}'" for name in self._names)
        return Condition(Level.OK, f"{self._publisher.topic_name} goes to {reported}")
