"""What the worker's child does in its tests."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

from shoecal_core.errors import NameNotFoundError
from shoecal_ros.common.worker import Link

_calls: list[None] = []


def add(link: Link, one: int, other: int) -> int:
    link.progress("adding")
    return one + other


def count(link: Link) -> int:
    _calls.append(None)
    return len(_calls)


def refuse(link: Link) -> None:
    raise NameNotFoundError("motion", "dance", ("landmarks",))


def stumble(link: Link) -> None:
    raise ValueError("nobody foresaw this")


def die(link: Link) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def wait_for_end(link: Link) -> str:
    link.progress(os.getpid())
    while not link.canceled():
        time.sleep(0.01)
    return "canceled"


def hang(link: Link) -> None:
    link.progress(os.getpid())
    time.sleep(1000.0)


def hang_silently(link: Link) -> None:
    time.sleep(1000.0)


def hang_together(link: Link) -> None:
    child = subprocess.Popen(["sleep", "1000"])
    link.progress(child.pid)
    child.wait()


def unspeakable(link: Link) -> object:
    return sys.stdin
