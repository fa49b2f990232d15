from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from core.stranger import Stranger
from ros.world import middleware_failed
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


OTHER_THREAD = """ (most recent call first):
  File "/a/shoecal_ros/common/log_pipe.py", line 69 in run

"""


@pytest.mark.parametrize(
    ("innermost", "failed"),
    [
        ('rclpy/node.py", line 1965 in destroy_node', True),
        ('rclpy/node.py", line 1203 in create_publisher', False),
        ('shoecal_ros/nodes/planner.py", line 20 in destroy_node', False),
    ],
)
@pytest.mark.parametrize(
    "begins",
    [
        f"Timeout (0:00:10)!\nThread 0x0f{OTHER_THREAD}Thread 0x0a",
        f"Fatal Python error: Segmentation fault\n\nThread 0x0f{OTHER_THREAD}Current thread 0x0a",
    ],
)
def test_only_the_middleware_may_fail_while_it_is_destroyed(
    begins: str, innermost: str, *, failed: bool
) -> None:
    trace = f"""{begins} (most recent call first):
  File "/a/{innermost}
  File "/a/shoecal_ros/common/process.py", line 100 in _live
"""
    assert middleware_failed(f"[INFO] closed\n{trace}") == failed
    assert not middleware_failed(trace.partition("\n")[2])
