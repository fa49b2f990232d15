"""What a user decides of a diagnosis, each setting with its unit."""

from __future__ import annotations

from dataclasses import dataclass

from shoecal_core.error_sources.settings import SignalSettings
from shoecal_core.settings import setting

ARM_M = 0.1
"""By which a material error of the CoP is one of the force, as a share of the weight."""


@dataclass(frozen=True)
class DiagnosisSettings(SignalSettings):
    """How samples are made and when something counts as found."""

    false_alarms: float = setting(
        0.05, "", "a cause is named when a robot within tolerance is less probable than this",
        minimum=1e-6, maximum=0.5,
    )  # fmt: skip
    material_m: float = setting(
        0.0002, "m", "errors of the CoP below this do not matter; of GRF the same share of the "
        "weight as this is of 0.1 m", minimum=0.0,
    )  # fmt: skip
    set_share: float = setting(
        0.95, "", "probability that a set of inseparable explanations holds",
        minimum=0.5, maximum=0.999,
    )  # fmt: skip
    causes_max: int = setting(2, "", "effects in one explanation at most", minimum=1, maximum=12)

    @property
    def material_share(self) -> float:
        """Errors of a force below this share of the weight do not matter."""
        return self.material_m / ARM_M
