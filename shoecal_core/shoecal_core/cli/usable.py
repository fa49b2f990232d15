"""Whether a calibration that was found may be used."""

from __future__ import annotations

from collections.abc import Mapping

from rich.console import Console

from shoecal_core.cli.prose import say
from shoecal_core.cli.tables import reason_lines
from shoecal_core.errors import PartialError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.screening.verdict import list_reasons


class CalibrationFailedError(PartialError):
    """A calibration was found that must not be used."""


def require_usable(
    calibration: Calibration, figures: Mapping[str, object], console: Console
) -> None:
    """Show the reasons of its verdict, and refuse it where that is FAIL.

    The worst reason of a FAIL stands in the error, and only there.

    Args:
        calibration: found.
        figures: of it, for machines.
        console: to show the reasons on.

    Raises:
        CalibrationFailedError: it must not be used.
    """
    failed = calibration.verdict == "FAIL"
    for line in reason_lines(calibration)[failed:]:
        say(console, line)
    if failed:
        reasons = list_reasons(calibration.reasons, 1)
        raise CalibrationFailedError(f"no calibration written: {reasons}", figures)
