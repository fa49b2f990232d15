"""Other nodes that command the joints: only those that a parameter names may."""

from __future__ import annotations

import time
from collections.abc import Callable

from rclpy.publisher import Publisher

from shoecal_ros.common.codes import Problem, joined
from shoecal_ros.common.graph_monitor import UNNAMED
from shoecal_ros.common.node import ShoecalNode

UNNAMED_S = 2.0
"""The name of a node is known a little later than its publisher; of other programs it never is."""


class Commanders:
    """Of the topic of commands.

    Attributes:
        problem: who publishes it, too, and the cure; None where only those do that may.
    """

    def __init__(
        self,
        node: ShoecalNode,
        publisher: Publisher,
        others: str,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """No publisher has been looked for yet.

        Args:
            node: that commands the joints.
            publisher: of its commands.
            others: names of nodes that may do so, too, separated by commas.
            clock: monotonic [s].
        """
        self.problem: Problem | None = None
        self._node = node
        self._topic = publisher.topic_name
        self._clock = clock
        self._named_at = clock()
        prefix = node.get_namespace().rstrip("/")
        names = [name.strip() for name in others.split(",")]
        self._others = {name if name.startswith("/") else f"{prefix}/{name}" for name in names}

    def look(self) -> None:
        """Look who is there."""
        found = self._node.peers.rivals(self._topic, self._others)
        named = self._node.peers.rivals(self._topic, {*self._others, UNNAMED})
        if len(found) == len(named):
            self._named_at = self._clock()
        new = self._clock() - self._named_at < UNNAMED_S
        problem = joined(named if new else found)
        self.problem = problem and Problem(
            problem.code, f"{problem}; name one that may in the planner's other_commanders"
        )
