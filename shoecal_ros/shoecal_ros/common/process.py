"""A node's process, from its beginning to its exit code."""

from __future__ import annotations

import faulthandler
import gc
import os
import re
import sys
import traceback
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NoReturn

import rclpy
from rclpy.exceptions import NameValidationException
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from shoecal_core.errors import ShoecalError, one_line
from shoecal_ros.common.end_asked import EndAsked
from shoecal_ros.common.log_pipe import log_pipe
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.parameter_files import ParameterFiles

SWITCH_S = 5e-4
"""For so long one thread may keep Python from another that waits."""
DEADLINE_S = 10.0
"""A process ends within this time once its node has left the robot safe."""


class RosArgumentsError(ShoecalError):
    """A command line that ROS cannot use."""


def run(make_node: Callable[[], ShoecalNode], args: Sequence[str] | None = None) -> NoReturn:
    """A node's process.

    It ends here, without the destructors of libraries: the middleware's may abort or hang.
    """
    code = 0
    try:
        with log_pipe() as terminal:
            _live(make_node, sys.argv if args is None else args, terminal)
    except ShoecalError as error:
        print(f"{Path(sys.argv[0]).stem}: {error}", file=sys.stderr)
        code = 1
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except Exception:  # noqa: BLE001 - as Python itself would end
        traceback.print_exc()
        code = 1
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(code)


def freeze_objects() -> None:
    """Let the garbage collector pass over all there is by now.

    Looking through it again and again holds messages up for a twentieth of a second.
    """
    gc.collect()
    gc.freeze()


def _live(make_node: Callable[[], ShoecalNode], args: Sequence[str], terminal: int) -> None:
    """Make a node and let it work until it is asked to end; whatever it ends with is raised."""
    files = ParameterFiles(args)
    # Where the middleware hangs with Python's lock held, only a thread of C can end the process.
    limit_end = partial(faulthandler.dump_traceback_later, DEADLINE_S, exit=True, file=terminal)
    node: ShoecalNode | None = None
    try:
        _init(args)
        # The node wakes up each `node.WATCH_S`.
        asked = EndAsked()
        try:
            node = make_node()
        except NameValidationException as error:
            raise RosArgumentsError(f"{one_line(str(error))}; correct __ns or __node") from error
        node.check_overrides(files)
        node.seal()
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        sys.setswitchinterval(SWITCH_S)
        freeze_objects()
        node.realtime.start()
        while rclpy.ok() and not asked.to_end:
            handler, _, _ = executor.wait_for_ready_callbacks()
            with node.turn:
                handler()
            handler.result()  # raises what it ended with
            if node.realtime.error is not None:
                raise node.realtime.error
    finally:
        if node is None:
            limit_end()
        else:
            node.end(when_safe=limit_end)
        rclpy.try_shutdown()


def _init(args: Sequence[str]) -> None:
    """Start the middleware; RosArgumentsError for arguments that it cannot use."""
    try:
        # The node ends before the middleware does: it may have to stop a robot yet.
        rclpy.init(args=list(args), signal_handler_options=SignalHandlerOptions.NO)
    except RuntimeError as error:
        reported = one_line(re.sub(r", at \S+:\d+", "", str(error)))
        raise RosArgumentsError(f"ROS arguments: {reported}; correct the command line") from error
