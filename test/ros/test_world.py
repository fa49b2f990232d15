from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from core.stranger import Stranger
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
