"""What another node knows of one's own: nobody sees that from here, but it can be asked."""

from __future__ import annotations

import math
import time

from rcl_interfaces.srv import GetParameters
from rclpy.node import Node
from rclpy.task import Future

AGAIN_S = 1.0
"""An answer may be lost: its sender waits for a short while only until it knows who asked."""


class Introduction:
    """Makes sure that another node knows everything that one's own has made before.

    What it publishes before it knows of a subscription is lost to it, and that a client is ready
    says only what is known here. But it is told of everything in the order in which that was made:
    once it answers the last client, it knows of all before.
    """

    def __init__(self, node: Node, other: str) -> None:
        """Begin; somebody has to spin the node.

        Args:
            node: one's own.
            other: name of the other one, with its namespace where that is not the root.
        """
        self._node = node
        self._client = node.create_client(GetParameters, f"{other}/get_parameters")
        self._answers: list[Future] = []
        self._asked_at = -math.inf

    @property
    def done(self) -> bool:
        """Whether the other one knows by now; to be looked at again and again."""
        if any(answer.done() for answer in self._answers):
            return True
        now = time.monotonic()
        if self._client.service_is_ready() and now - self._asked_at > AGAIN_S:
            self._answers.append(self._client.call_async(GetParameters.Request()))
            self._asked_at = now
        return False

    def end(self) -> None:
        """Ask no more."""
        self._node.destroy_client(self._client)
