"""Ctrl-C as a wish: who works looks at it when nothing is half done."""

from __future__ import annotations

import signal


class EndAsked:
    """Whether Ctrl-C was pressed or the process asked to end; at a second Ctrl-C it does at once.

    SIGTERM may come twice for one wish: from a service manager, and because launch has ended.

    Attributes:
        to_end: whether it shall.
    """

    def __init__(self) -> None:
        """Not yet; from now on nothing is interrupted in its middle."""
        self.to_end = False
        self._before = {
            number: signal.signal(number, self._ask) for number in (signal.SIGINT, signal.SIGTERM)
        }

    def close(self) -> None:
        """Let both mean again what they did before."""
        for number, handler in self._before.items():
            signal.signal(number, handler)

    def _ask(self, number: int, frame: object) -> None:
        del frame
        if self.to_end and number == signal.SIGINT:
            raise KeyboardInterrupt
        self.to_end = True
