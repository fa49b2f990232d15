from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from core.stranger import Stranger
from ros.world import middleware_hung
from shoecal_core.workspace import ros_environment

ALONE = """
import sys
from pathlib import Path
from ros.world import World
with World(Path(sys.argv[1])) as world:
    node = world.start("model")
    world.until_discovered_by("model")
    print(node.pid, flush=True)
    node.wait()
"""


def test_no_node_outlives_a_killed_world(tmp_path: Path) -> None:
    environment = {**ros_environment(), "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", ALONE, str(tmp_path)]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as world:
        assert world.stdout is not None
        with Stranger(int(world.stdout.readline())) as node:
            world.kill()
            assert node.ends()


@pytest.mark.parametrize(
    ("innermost", "hung"),
    [("site-packages/rclpy/node.py", True), ("shoecal_ros/nodes/planner.py", False)],
)
def test_only_the_middleware_may_hang_at_the_end(innermost: str, *, hung: bool) -> None:
    ended = f"""[INFO] closed
Timeout (0:00:10)!
Thread 0x00007f6607fff6c0 (most recent call first):
  File "/a/shoecal_ros/common/log_pipe.py", line 69 in run

Thread 0x00007f66219ed540 (most recent call first):
  File "/a/{innermost}", line 1965 in destroy_node
  File "/a/shoecal_ros/common/process.py", line 100 in _live
"""
    assert middleware_hung(ended) == hung
    assert not middleware_hung("Traceback (most recent call first):\n  File /a/rclpy/node.py")
