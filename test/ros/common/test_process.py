from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from shoecal_core.workspace import ros_environment

SCRIPT = Path(__file__).with_name("hanging_node.py")


@pytest.mark.parametrize(("how", "code"), [("hang", 1), ("abort", 0)])
def test_a_process_ends_once_the_robot_is_safe(how: str, code: int) -> None:
    with subprocess.Popen(
        [sys.executable, str(SCRIPT), how], env=ros_environment(), stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stderr is not None
        for line in process.stderr:
            if "begun" in line:
                break
        process.send_signal(signal.SIGINT)
        said = process.stderr.read()
    assert process.returncode == code, said
    # Whoever reports a hang can say where it was.
    assert ("destroy_node" in said) == (how == "hang")
