"""Waiting in the jobs of a node, while everything else in it goes on."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Generator
from typing import TypeVar

T = TypeVar("T")


class _Pause:
    """Lets everything else run once: the executor resumes a job whenever it has woken up."""

    def __await__(self) -> Generator[None, None, None]:
        yield


async def until(condition: Callable[[], bool], timeout_s: float) -> bool:
    """Wait for a condition that callbacks of this node bring about; whether it came in time.

    It is looked at whenever the node wakes up: at every message, and every `node.WATCH_S`.

    Args:
        condition: cheap.
        timeout_s: wall-clock time.
    """
    deadline = time.monotonic() + timeout_s
    while not condition():
        if time.monotonic() > deadline:
            return False
        await _Pause()
    return True


async def aside(work: Callable[[], T]) -> T:
    """What a pure function gives that takes up to a second: everything else goes on meanwhile."""
    found: list[T] = []
    errors: list[Exception] = []

    def do() -> None:
        try:
            found.append(work())
        except Exception as error:  # noqa: BLE001 (raised again for who waits)
            errors.append(error)

    thread = threading.Thread(target=do, daemon=True, name="aside")
    thread.start()
    await until(lambda: not thread.is_alive(), math.inf)
    if errors:
        raise errors[0]
    return found[0]
