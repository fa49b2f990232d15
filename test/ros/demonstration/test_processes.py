from __future__ import annotations

import signal
import subprocess
from pathlib import Path

import pytest

from shoecal_core.workspace import ros_environment
from shoecal_ros.demonstration.processes import Nodes


def test_nodes_that_have_just_been_started_in_the_background_end_when_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(subprocess.Popen, "kill", lambda _: pytest.fail("had to be killed"))
    # As a shell does for what it starts with `&`.
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with Nodes(tmp_path, ros_environment()) as nodes:
            nodes.start("model", {})
    finally:
        signal.signal(signal.SIGINT, before)
