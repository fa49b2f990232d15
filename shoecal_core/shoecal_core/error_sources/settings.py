"""What is assumed of signals and of the baseline's parameters, each setting with its unit."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.samples.settings import SampleSettings
from shoecal_core.settings import setting
from shoecal_core.shoe.priors import PriorSettings


@dataclass(frozen=True)
class SignalSettings(PriorSettings, SampleSettings):
    """Priors of gains and offsets, and errors that any model has."""

    parity_residual: float = setting(
        0.1, "", "cells of a foot count as lying on one plane when what is off it is at most this "
        "share of their third direction", minimum=0.0,
    )  # fmt: skip
    model_error_rad: float = setting(
        6e-4,
        "rad",
        "errors that any model has, as a tilt of the soles; alike for correlation_s",
        minimum=0.0,
    )
    joint_zero_rad: float = setting(
        2e-3, "rad", "how well joints' zeros are set: so flat do soles stand by the joints",
        minimum=1e-6,
    )  # fmt: skip
