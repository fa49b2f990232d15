"""What is assumed of signals and of the baseline's parameters, each setting with its unit."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.samples.settings import SampleSettings
from shoecal_core.settings import setting


@dataclass(frozen=True)
class SignalSettings(SampleSettings):
    """Priors of gains and offsets, and errors that any model has."""

    gain_std: float = setting(
        1.0, "", "how far gains are off their initial guess, as a share of it", minimum=1e-6
    )
    nominal_gain_std: float = setting(
        0.1, "", "the same for channels whose data sheet gives a gain", minimum=1e-6
    )
    offset_std_n: float = setting(
        30.0, "N", "how far offsets are off their initial guess", minimum=1e-6
    )
    parity_residual: float = setting(
        0.1, "", "cells of a foot count as lying on one plane when what is off it is at most this "
        "share of their third direction", minimum=0.0,
    )  # fmt: skip
    model_error_rad: float = setting(
        6e-4, "rad", "errors that any model has, as a tilt of the soles", minimum=0.0
    )
    model_error_s: float = setting(2.0, "s", "for how long such errors stay alike", minimum=1e-3)
    joint_zero_rad: float = setting(
        2e-3, "rad", "how well joints' zeros are set: so flat do soles stand by the joints",
        minimum=1e-6,
    )  # fmt: skip
