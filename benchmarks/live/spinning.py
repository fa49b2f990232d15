"""A node's process, until it is told to end."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node


def spin(make: Callable[[], Node]) -> Node:
    """Spin a node until an interrupt; the node, to see what it has."""
    rclpy.init()
    node = make()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        executor.spin()
    return node
