"""Says at once when an input has fallen silent, instead of at the node's next watch."""

from __future__ import annotations

from collections.abc import Callable

from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.inputs.arrival_monitor import ArrivalMonitor

LEAST_S = 1e-3
"""From one look to the next."""


class InputTimeout:
    """A timer for the moment at which news may be overdue."""

    def __init__(
        self, node: ShoecalNode, heard: ArrivalMonitor, report: Callable[[], None]
    ) -> None:
        """Wait from now on.

        Args:
            node: whose input it is.
            heard: since when it has sent nothing.
            report: called when that has been for too long.
        """
        self._node, self._heard, self._report = node, heard, report
        self._timer = node.wall_timer(heard.next_look_s, lambda: node.start(self._look))

    async def _look(self) -> None:
        """After what has come meanwhile was taken: a node that was held up hears late itself."""
        if self._heard.silent:
            self._report()
        self._timer.timer_period_ns = round(1e9 * max(self._heard.next_look_s, LEAST_S))
        self._timer.reset()
