"""A node's process, from its beginning to its exit code."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import rclpy
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from shoecal_core.errors import ShoecalError
from shoecal_ros.common.end_asked import EndAsked
from shoecal_ros.common.log_pipe import log_pipe
from shoecal_ros.common.node import ShoecalNode

SWITCH_S = 5e-4
"""For so long one thread may keep Python from another that waits."""


def run(make_node: Callable[[], ShoecalNode], args: Sequence[str] | None = None) -> int:
    """A node's process; its exit code."""
    try:
        with log_pipe():
            _live(make_node, args)
    except ShoecalError as error:
        print(f"{Path(sys.argv[0]).stem}: {error}", file=sys.stderr, flush=True)
        return 1
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    return 0


def keep_what_stands() -> None:
    """Let the garbage collector pass over all there is by now.

    Looking through it again and again holds messages up for a twentieth of a second.
    """
    gc.collect()
    gc.freeze()


def _live(make_node: Callable[[], ShoecalNode], args: Sequence[str] | None) -> None:
    """Make a node and let it work until it is asked to end; whatever it ends with is raised."""
    node: ShoecalNode | None = None
    try:
        # The node ends before the middleware does: it may have to stop a robot yet.
        rclpy.init(
            args=None if args is None else list(args),
            signal_handler_options=SignalHandlerOptions.NO,
        )
        # The node wakes up each `node.WATCH_S`.
        asked = EndAsked()
        node = make_node()
        node.check_overrides()
        node.seal()
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        sys.setswitchinterval(SWITCH_S)
        keep_what_stands()
        node.quick.start()
        while rclpy.ok() and not asked.to_end:
            handler, _, _ = executor.wait_for_ready_callbacks()
            with node.turn:
                handler()
            handler.result()  # raises what it ended with
            if node.quick.error is not None:
                raise node.quick.error
    finally:
        if node is not None:
            node.end()
        rclpy.try_shutdown()
