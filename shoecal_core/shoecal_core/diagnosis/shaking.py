"""Recordings of a robot that shook: what is found in them may be caused by the shaking."""

from __future__ import annotations

import numpy as np

from shoecal_core.error_sources.signal_model import SignalModel
from shoecal_core.screening.cells.spikes import find_jumps
from shoecal_core.screening.events import LEAST_JUMP_STDS
from shoecal_core.screening.noise import noise
from shoecal_core.screening.settings import CalibrationSettings

MUCH = 0.1
"""Share of the samples from which it is reported."""


def shaking(signal_model: SignalModel) -> list[str]:
    """In words, when readings of a foot jump together for much of the time, and where most."""
    samples = signal_model.samples
    gain = signal_model.parameters.gain
    least = LEAST_JUMP_STDS * CalibrationSettings().force_std_n
    shares = {
        track.run: float(
            find_jumps(samples.shoe, track.readings, noise(track.readings), gain, least).hits.mean()
        )
        for track in samples.tracks
        if not track.walks
    }
    mean = float(np.mean(list(shares.values()))) if shares else 0.0
    if mean < MUCH:
        return []
    most = max(shares, key=lambda run: shares[run])
    text = (
        f"the robot shook: readings of several cells jump for {mean:.0%} of the samples (run "
        f"{most}: {shares[most]:.0%}), which may cause what is found here: see that gears and "
        "floor are firm, and record again"
    )
    return [text]
