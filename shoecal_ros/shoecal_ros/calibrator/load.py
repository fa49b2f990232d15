"""Which feet carry load, with hysteresis against flutter, and whose frame the CoP is in."""

from __future__ import annotations

import math

from shoecal_core.errors import ShoecalError

LEFT, RIGHT = 0, 1


class LoadSwitch:
    """Loaded feet, with hysteresis.

    Attributes:
        loaded: left, right.
    """

    def __init__(self, on: float, off: float) -> None:
        """No foot is loaded.

        Args:
            on: with more than this on it a foot becomes loaded [N].
            off: with less it is no longer [N].
        """
        if not 0.0 < off <= on:
            raise ShoecalError(
                f"load_on_n {on:g} N and load_off_n {off:g} N: must be positive, and the first "
                "not below the second; correct them"
            )
        self._on, self._off = on, off
        self.loaded = (False, False)

    def update(self, left: float, right: float) -> tuple[bool, bool]:
        """Take both feet's force [N]; NaN, not known, changes nothing."""
        self.loaded = (self._switched(LEFT, left), self._switched(RIGHT, right))
        return self.loaded

    def _switched(self, foot: int, force: float) -> bool:
        if math.isnan(force):
            return self.loaded[foot]
        return force > (self._off if self.loaded[foot] else self._on)

    @property
    def frame(self) -> int:
        """Foot in whose sole frame the combined CoP is: the left one while it carries load."""
        return RIGHT if self.loaded == (False, True) else LEFT
