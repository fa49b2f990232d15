"""Whether joints and readings of a run were stamped by one clock."""

from __future__ import annotations

from shoecal_core.recording.errors import RecordingError
from shoecal_core.recording.run import Run

FAR_S = 1.0
"""What was recorded together starts and ends within this of each other."""
ALIKE = 0.5
"""A shift is as long at both ends, to within this share of it; what broke off is not."""


def check_clocks(run: Run) -> None:
    """Refuse a run whose joints and readings both start and end apart, by about the same time.

    Smaller differences are what the effect `latency` is looked for by.

    Raises:
        RecordingError: the stamps are of two clocks.
    """
    first = float(run.joints.time[0] - run.readings.time[0])
    last = float(run.joints.time[-1] - run.readings.time[-1])
    shift = 0.5 * (first + last)
    if abs(shift) > FAR_S and abs(first - last) < ALIKE * abs(shift):
        raise RecordingError(
            run.path,
            f"the stamps of joints and readings are {abs(shift):.1f} s apart, so none of them "
            "belong together; set both devices' clocks and record it again",
        )
