"""Whose turn it is among the threads of a node: none goes twice before the others."""

from __future__ import annotations

import threading
from types import TracebackType


class CallbackLock:
    """A lock that goes to who waits, not to who had it just now.

    A thread with always more to do would otherwise take a plain lock back before another one that
    waits for it has woken up: a thousand requests a second then leave no CoP.
    """

    def __init__(self) -> None:
        self._next = threading.Lock()
        self._held = threading.Lock()

    def __enter__(self) -> None:
        # Who waits holds the place of the next one, and who comes back has to queue for it.
        with self._next:
            self._held.acquire()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._held.release()
