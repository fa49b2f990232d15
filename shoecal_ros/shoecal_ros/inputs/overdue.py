"""Says at once when an input has fallen silent, instead of at the node's next watch."""

from __future__ import annotations

from collections.abc import Callable

from shoecal_ros.common.runtime import ShoecalNode
from shoecal_ros.inputs.last_heard import LastHeard


class Overdue:
    """A timer that is put off whenever news come."""

    def __init__(self, node: ShoecalNode, heard: LastHeard, tell: Callable[[], None]) -> None:
        """Wait from now on.

        Args:
            node: whose input it is.
            heard: since when it has told nothing.
            tell: called when that has been for too long.
        """
        self._node, self._heard, self._tell = node, heard, tell
        self._timer = node.wall_timer(heard.patience_s, lambda: node.start(self._look))

    def wait(self) -> None:
        """Something may have come: wait anew."""
        patience_ns = round(1e9 * self._heard.patience_s)
        if patience_ns != self._timer.timer_period_ns:
            self._timer.timer_period_ns = patience_ns
        self._timer.reset()

    async def _look(self) -> None:
        """After what has come meanwhile was taken: a node that was held up hears late itself."""
        if self._heard.silent:
            self._tell()
