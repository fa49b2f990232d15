"""How a session becomes samples, each setting with its unit."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.settings import Settings, setting


@dataclass(frozen=True)
class SampleSettings(Settings):
    """Rates of samples and filters, and when a foot is in the air."""

    rate_hz: float = setting(
        5.0, "1/s", "samples that regressions see; what happens faster is worked out before",
        minimum=0.5,
    )  # fmt: skip
    walking_rate_hz: float = setting(
        1.0, "1/s", "the same for sessions in which the robot walks: what the model misses within "
        "a step would pass for small gains", minimum=0.1,
    )  # fmt: skip
    samples_max: int = setting(
        4000, "", "samples of a whole session; longer ones are sampled more slowly", minimum=200
    )
    filter_rate_hz: float = setting(
        100.0, "1/s", "rate at which filters, delays and derivatives are worked out", minimum=5.0
    )
    lifted_m: float = setting(
        0.0025, "m", "a foot higher than this above the other one is in the air", minimum=1e-4
    )
