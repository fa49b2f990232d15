"""Whether the robot may be moved: only after somebody said so, and not for ever."""

from __future__ import annotations

from collections.abc import Callable


class Arming:
    """Armed by a person or a program; ends by itself when it is not used.

    Attributes:
        armed: whether motions may be sent.
    """

    def __init__(self, timeout_s: float, clock: Callable[[], float]) -> None:
        """Not armed.

        Args:
            timeout_s: without use for that long it is disarmed [s].
            clock: monotonic wall clock [s].
        """
        self.armed = False
        self._timeout_s = timeout_s
        self._clock = clock
        self._used = 0.0

    def set(self, armed: bool) -> None:
        """Arm or disarm."""
        self.armed = armed
        self._used = self._clock()

    def use(self) -> None:
        """A motion is being prepared, sent or followed."""
        self._used = self._clock()

    def expire(self) -> bool:
        """Disarm what was not used for too long; True when that has just happened."""
        if self.armed and self._clock() - self._used > self._timeout_s:
            self.armed = False
            return True
        return False
