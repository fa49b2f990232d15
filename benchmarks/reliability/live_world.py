"""Rows with real nodes: processes in a ROS domain of their own, beside a robot of messages alone.

The nodes and the client that talks to them are those of the nodes' tests (`test/ros/world.py`).
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Protocol
from unittest.mock import patch

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus

from pages import ROOT
from reliability.row import Progress, Result, merge
from reliability.tries import BrokenError, run_tries
from shoecal_ros.common.process import freeze_objects
from shoecal_ros.demonstration.domain import reserve_domain

if str(ROOT / "test") not in sys.path:
    sys.path.append(str(ROOT / "test"))

from ros.world import Goal, World

LONGEST = 300
"""Letters of a failure: those of a wait in vain hold the nodes' logs."""

__all__ = [
    "Goal", "Scene", "Start", "World", "is_well", "live_tries", "live_world", "wait",
]  # fmt: skip


class Scene(Protocol):
    """The nodes of a row, and its robot."""

    def attempt(self, number: int, rng: np.random.Generator, /) -> float | None:
        """Do one try; its figure if it has one.

        Raises:
            BrokenError: when what must hold does not.
        """


Start = Callable[[World], Scene]
"""Starts the nodes of a row."""


@contextmanager
def live_world() -> Iterator[World]:
    """A world without nodes, in a folder that is removed afterwards."""
    domain, token = reserve_domain()
    own = {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(ROOT / "test" / "ros" / "quick_discovery.xml"),
    }
    with (
        token,
        tempfile.TemporaryDirectory(prefix="shoecal-faults-") as folder,
        patch.dict(os.environ, own),
        World(Path(folder)) as world,
    ):
        yield world


def wait(world: World, seconds: float) -> None:
    """Let messages come for so long."""
    end = time.monotonic() + seconds
    world.until(lambda: time.monotonic() >= end)


def is_well(world: World, node: str, subject: str) -> bool:
    """Whether a node's last diagnostic of a subject is OK."""
    found = world.diagnosis(node, subject)
    return found is not None and found.level == DiagnosticStatus.OK


def live_tries(
    start: Start,
    first: int,
    count: int,
    seed: int,
    progress: Progress,
    worst: str = "",
    most: float = math.inf,
) -> Result:
    """Tries beside nodes that keep running from one try to the next.

    A failed try is the last one, as it may leave nodes in any state; the next call starts others.

    Args:
        start: starts the nodes.
        first, count, seed, progress: as for `run_tries`.
        worst: the largest figure in words.
        most: largest figure of a try that has not failed.
    """
    results: list[Result] = []
    try:
        with live_world() as world:
            scene = start(world)
            freeze_objects()  # as nodes do: collecting garbage would make the listener late

            def limited(number: int, rng: np.random.Generator) -> float:
                figure = scene.attempt(number, rng) or 0.0
                if figure > most:
                    raise BrokenError(worst.format(figure))
                return figure

            for number in range(first, first + count):
                results.append(run_tries(limited, number, 1, seed, lambda _: None, worst))
                progress(len(results))
                if results[-1].failed:
                    break
    except AssertionError as error:  # nodes that do not start or do not end as they should
        if not merge(results).failed:
            results = [*results[: count - 1], Result(1, 1, str(error))]
    result = merge(results)
    return replace(result, worst=" ".join(result.worst.split())[:LONGEST])
