"""Whether the robot may be moved: only after somebody said so, and not for ever."""

from __future__ import annotations

from collections.abc import Callable


class Arming:
    """Armed by a person or a program; ends by itself when it is not used.

    Attributes:
        armed: whether motions may be sent.
        disarmings: how often that was taken back, or ended by itself: a motion that was allowed
            before is not allowed again.
    """

    def __init__(self, timeout_s: float, clock: Callable[[], float]) -> None:
        """Not armed.

        Args:
            timeout_s: without use for that long it is disarmed [s].
            clock: monotonic wall clock [s].
        """
        self.armed = False
        self.disarmings = 0
        self._timeout_s = timeout_s
        self._clock = clock
        self._used = 0.0

    def set(self, armed: bool) -> None:
        """Arm or disarm."""
        self.disarmings += self.armed and not armed
        self.armed = armed
        self._used = self._clock()

    def use(self) -> None:
        """A motion is being prepared, sent or followed."""
        self._used = self._clock()

    def expire(self) -> bool:
        """Disarm what was not used for too long; True when that has just happened."""
        if self.armed and self._clock() - self._used > self._timeout_s:
            self.set(False)
            return True
        return False
