"""Where a calibration was made: in simulated or wall-clock time, on which host and device."""

from __future__ import annotations

import socket
from collections.abc import Iterable
from dataclasses import dataclass

from shoecal_core.estimation.calibration import Calibration

EPOCH_NS = 946_684_800 * 10**9
"""Year 2000: simulated clocks start at zero and never get there."""


@dataclass(frozen=True)
class Origin:
    """Where a calibration was made.

    Attributes:
        simulated: in simulated time, so by simulated cells.
        host: name of the computer; empty where it is not known.
        device: frame_id of the devices that sent the voltages; empty where it is not known.
    """

    simulated: bool
    host: str = ""
    device: str = ""

    @classmethod
    def here(cls, *, simulated: bool, devices: Iterable[str]) -> Origin:
        """This computer and the devices that are heard now."""
        return cls(simulated, socket.gethostname(), ", ".join(sorted(devices)))

    @classmethod
    def of(cls, calibration: Calibration) -> Origin:
        """What a calibration's own time stamp says, where nothing else is known."""
        return cls(calibration.made_ns < EPOCH_NS)

    def __str__(self) -> str:
        clock = "in simulated time" if self.simulated else "in wall-clock time"
        host = f" on host '{self.host}'" if self.host else ""
        device = f" with device '{self.device}'" if self.device else ""
        return f"{clock}{host}{device}"
