"""Which nodes of the suite have fallen silent: a killed one cannot say so itself."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Condition, Level

ADAPTERS = ("nao_lola_adapter", "naoqi_adapter", "controller_adapter")
SUITE = frozenset({"shoe_driver", "model", "planner", "calibrator", "simulator", *ADAPTERS})
"""Who is missed; not `voltage_stream`, which goes with the program that reads it."""
SILENT_S = 3.5
"""Every node reports its condition once a second."""
ENDED = "ended"


class LivenessMonitor:
    """Hears diagnostics of the other nodes."""

    def __init__(self, own: str, clock: Callable[[], float] = time.monotonic) -> None:
        """No node has been heard.

        Args:
            own: name of the node that listens.
            clock: monotonic [s].
        """
        self._own = own
        self._clock = clock
        self._heard: dict[str, float] = {}

    def take(self, messages: Sequence[DiagnosticArray]) -> None:
        """Take diagnostics of any node."""
        now = self._clock()
        for message in messages:
            for status in message.status:
                name = status.hardware_id
                if name in SUITE and name != self._own and status.name.startswith(f"{name}: "):
                    self._heard[name] = now
                    if status.name == f"{name}: {ENDED}":
                        del self._heard[name]

    @property
    def condition(self) -> Condition:
        """For diagnostics: who has fallen silent without saying that it ends."""
        now = self._clock()
        silent = [name for name, at in self._heard.items() if now - at > SILENT_S]
        if silent:
            return Condition(
                Level.ERROR,
                f"{', '.join(sorted(silent))} sent no diagnostics for {SILENT_S:g} s, killed or "
                "hanging: start it again",
                code=Code.NODE_SILENT,
            )
        return Condition(Level.OK, "no node has fallen silent", {"heard": ", ".join(self._heard)})


def end_notice(name: str) -> DiagnosticArray:
    """Last words of a node that ends as it should."""
    status = DiagnosticStatus(
        level=bytes([Level.STALE]), name=f"{name}: {ENDED}", message=ENDED, hardware_id=name,
        values=[KeyValue(key="code", value=Code.ENDED.value)],
    )  # fmt: skip
    return DiagnosticArray(status=[status])
