"""The calibration that is active, as sentences and diagnostics."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import UTC, datetime

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.screening.verdict import list_reasons, split_reason
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.origin import Origin

UNCALIBRATED = "uncalibrated: no forces are published; call shoe/self_calibrate"


@dataclass(frozen=True)
class ActiveCalibration:
    """The calibration that is applied to the readings.

    Attributes:
        calibration: whole.
        origin: where it was made.
        since_ns: since when [ns].
        temperature: of the shoes now [degC], NaN where no device reports it.
    """

    calibration: Calibration
    origin: Origin
    since_ns: int
    temperature: float

    @property
    def since(self) -> str:
        """When it was put in force, in UTC."""
        moment = datetime.fromtimestamp(self.since_ns / 1e9, UTC)
        return moment.strftime("%Y-%m-%d %H:%M:%S UTC")

    @property
    def sentence(self) -> str:
        """One line for a person."""
        made = self.calibration
        reported = (
            f"'{made.id}' ({made.source}, {made.verdict}) in force since {self.since} on robot "
            f"'{made.robot}' and shoe '{made.shoe}', made {self.origin}"
        )
        if not math.isnan(made.temperature):
            reported += f" at {made.temperature:.1f} degC"
        if not math.isnan(self.temperature):
            reported += f", now {self.temperature:.1f} degC"
        return reported

    @property
    def _reasons(self) -> list[str]:
        """Without the verdict's own level, which stands before them."""
        verdict = self.calibration.verdict
        reported = [split_reason(one, verdict) for one in self.calibration.reasons]
        return [text if level == verdict else f"{level}: {text}" for level, text in reported]

    def condition(self, largest_gap: float, **values: object) -> Condition:
        """For diagnostics.

        Args:
            largest_gap: by which the temperature may differ from the calibration's [degC].
            values: further figures.
        """
        made = self.calibration
        code, message = Code.OK, f"'{made.id}' in force ({made.verdict})"
        if made.verdict != "PASS":
            code = Code.CALIBRATION_WARNED
            message = f"{message}: {list_reasons(self._reasons)}; correct that and calibrate again"
        # NaN, not known, is no gap.
        if abs(self.temperature - made.temperature) > largest_gap:
            code = Code.TEMPERATURE_GAP
            message = (
                f"calibrated at {made.temperature:.0f} degC, now {self.temperature:.0f}: call "
                f"shoe/rezero; {message}"
            )
        reported = {
            "id": made.id,
            "source": made.source,
            "verdict": made.verdict,
            "in_force_since": self.since,
            "robot": made.robot,
            "shoe": made.shoe,
            "made": str(self.origin),
            "temperature_then_degc": _known(made.temperature),
            "temperature_now_degc": _known(self.temperature),
            **values,
        }
        level = Level.OK if code is Code.OK else Level.WARN
        return Condition(level, message, {key: str(value) for key, value in reported.items()}, code)


def _known(temperature: float) -> str:
    return "not known" if math.isnan(temperature) else f"{temperature:.1f}"
