"""Real nodes for rows, in a ROS domain of their own: processes and a client that talks to them.

They are those that the nodes' tests are made with: `ros.world`, `ros.standing_robot` and others.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

from pages import ROOT
from shoecal_ros.demonstration.domain import reserve_domain

if str(ROOT / "test") not in sys.path:
    sys.path.append(str(ROOT / "test"))

from ros.world import Goal, Received, World

COMPILE_S = 600.0
"""A planner compiles at its first start, and stands back for everything else."""

__all__ = ["COMPILE_S", "Goal", "Received", "World", "live_world"]


@contextmanager
def live_world() -> Iterator[World]:
    """A world without nodes, in a folder that is gone afterwards."""
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
