"""Messages of robots' drivers: the real packages where they are installed, else stand-ins."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import patch

STAND_INS = Path(__file__).parents[3] / "build/stand_ins"
SCRIPT = Path(__file__).with_name("stand_in_robot.py")
PACKAGES = {
    "nao_lola": ("nao_lola_command_msgs", "nao_lola_sensor_msgs"),
    "naoqi": ("naoqi_bridge_msgs",),
    "action": ("control_msgs",),
    "slow_action": ("control_msgs",),
    "refusing_action": ("control_msgs",),
    "hanging_action": ("control_msgs",),
    "stuck_action": ("control_msgs",),
    "settling_action": ("control_msgs",),
    "topic": (),
    "tf": ("tf2_msgs",),
}


class NoMessagesError(Exception):
    """There are none of a driver."""


@contextmanager
def messages_of(kind: str) -> Iterator[None]:
    """Processes that are started meanwhile find the messages of a kind of robot.

    Raises:
        NoMessagesError: where there are none.
    """
    paths = {"PYTHONPATH": [Path(__file__).parents[2]], "LD_LIBRARY_PATH": []}
    if not all(importlib.util.find_spec(package) for package in PACKAGES[kind]):
        if not (STAND_INS / ".complete").is_file():
            raise NoMessagesError("no messages of this driver, nor stand-ins; make stand-ins")
        library = STAND_INS / "install/lib"
        paths["PYTHONPATH"] += library.glob("python3.*/site-packages")
        paths["LD_LIBRARY_PATH"].append(library)
    searched = {
        name: os.pathsep.join([*map(str, added), *filter(None, [os.environ.get(name)])])
        for name, added in paths.items()
    }
    with patch.dict(os.environ, searched):
        yield
