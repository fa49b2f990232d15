"""How stamps and readings of a recording go with its joint angles in time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from shoecal_core.recording.run import Run
from shoecal_core.samples.aligned import Aligned
from shoecal_core.screening.clocks.jumps import ClockJump, clock_jump
from shoecal_core.screening.clocks.smoothed import Smoothing, smoothing
from shoecal_core.screening.clocks.time_offsets import clock_rate, cop_tracks, time_offset
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe


@dataclass(frozen=True)
class Timing:
    """What the CoP shows of it where it moves fast.

    Attributes:
        late: joints are late by so much against the readings [s]; it can be put right.
        clock_rate: by which the readings' clock runs faster than the joints', as a share.
        smoothed: the filter that the readings went through.
        jump: of a clock that was set.
    """

    late: float = 0.0
    clock_rate: float = 0.0
    smoothed: Smoothing | None = None
    jump: ClockJump | None = None

    @property
    def explained(self) -> bool:
        """The offset is a clock's that is fast or was set, or a filter's, which is named itself."""
        filtered = self.smoothed is not None and self.smoothed.back
        return bool(self.clock_rate) or self.jump is not None or filtered


def timing_of(
    runs: Mapping[int, Run],
    aligned: Mapping[int, Aligned],
    shoe: Shoe,
    weight: float,
    settings: CalibrationSettings,
) -> Timing:
    """Of runs in double support.

    Args:
        runs, aligned: by number, by the stamps as they are.
        weight: of robot and shoes [N].
    """
    standing = {
        number: aligned[number] for number, run in runs.items() if run.info.support is not None
    }
    tracks = cop_tracks(standing, shoe, weight, settings)
    smoothed = smoothing(tracks)
    starts = {number: run.start_ns / 1e9 for number, run in runs.items()}
    # What a filter leaves of the CoP drifts against the model as a clock's does.
    jump = None if smoothed else clock_jump(tracks)
    rate = 0.0 if smoothed or jump else clock_rate(starts, tracks)
    return Timing(time_offset(tracks), rate, smoothed, jump)
