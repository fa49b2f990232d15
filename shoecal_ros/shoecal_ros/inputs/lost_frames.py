"""Frames that never came here, by the counters of those that did."""

from __future__ import annotations

from collections.abc import Collection

MODULUS = 2**32


class LostFrames:
    """Counts the gaps in the devices' counters, wherever on the way they came from.

    Attributes:
        count: frames lost so far.
    """

    def __init__(self) -> None:
        self.count = 0
        self._last: dict[str, int] = {}

    @property
    def sources(self) -> Collection[str]:
        """Names of all that have sent frames."""
        return self._last.keys()

    def note(self, source: str, sequence: int) -> None:
        """A source's frame has come; a counter that goes back started again and shows no loss."""
        last = self._last.get(source)
        self._last[source] = sequence
        if last is not None:
            step = (sequence - last) % MODULUS
            if 1 < step < MODULUS // 2:
                self.count += step - 1
