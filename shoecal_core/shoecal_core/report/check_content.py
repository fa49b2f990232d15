"""What the report on a session before any calibration is made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from shoecal_core.estimation.weight import Weighed
from shoecal_core.recording.run import Run
from shoecal_core.recording.session import RunEntry, Session
from shoecal_core.robot.robot import Robot
from shoecal_core.samples.aligned import Aligned
from shoecal_core.samples.zeros import ZeroFigures
from shoecal_core.screening.result import Screening


@dataclass(frozen=True)
class CheckReport:
    """A session as `shoecal check` finds it.

    Attributes:
        session: the folder.
        robot: in its shoes.
        entries: of the runs that can be read.
        runs: by number.
        aligned: of them, where joint angles and readings go together.
        screening: what was found in them.
        problems: what is in the way of a calibration, a line each.
        warnings: what is not, but should be looked at.
        zeros: what feet read in the air.
        weighed: the weight by data sheets; None where it cannot be known.
    """

    session: Session
    robot: Robot
    entries: tuple[RunEntry, ...]
    runs: Mapping[int, Run]
    aligned: Mapping[int, Aligned]
    screening: Screening
    problems: tuple[str, ...]
    warnings: tuple[str, ...]
    zeros: tuple[ZeroFigures, ...] = ()
    weighed: Weighed | None = None

    @property
    def verdict(self) -> str:
        """PASS, WARN or FAIL."""
        return "FAIL" if self.problems else "WARN" if self.warnings else "PASS"
