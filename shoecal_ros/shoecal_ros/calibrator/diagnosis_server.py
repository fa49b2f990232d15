"""Action `shoe/diagnose`: one diagnosis at a time."""

from __future__ import annotations

from typing import Any

from shoecal_msgs.action import Diagnose

from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.diagnosis_job import DiagnosisJob
from shoecal_ros.calibrator.job_server import JobServer
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.refusal import RefusedError


class DiagnosisServer(JobServer[DiagnosisJob]):
    """Takes goals, runs the job, and reports what it found."""

    def __init__(self, node: CalibratorBase) -> None:
        super().__init__(node, Diagnose, "shoe/diagnose", "diagnosis", DiagnosisJob)
        self._last = Condition(Level.OK, "none yet")

    @property
    def condition(self) -> Condition:
        """How far it is, or how the last one ended, for diagnostics."""
        if self._job is None:
            return self._last
        return Condition(Level.OK, "under way", self._job.figures)

    async def _do(self, job: DiagnosisJob, result: Any) -> str:
        try:
            message = await super()._do(job, result)
        except RefusedError as refusal:
            values = {"error_code": str(refusal.code)}
            reported = f"ended: {refusal}"
            self._last = Condition(Level.WARN, reported, values, Code.DIAGNOSIS_ENDED)
            raise
        self._last = Condition(Level.OK, message)
        return message

    async def _work(self, job: DiagnosisJob, result: Any) -> str:
        try:
            return await job.run()
        finally:
            # Also of a job that ended before its time.
            if (found := job.found) is not None:
                result.verdict, result.json = found.verdict, found.json
                result.report = str(found.report)
                result.proposed, result.separates = found.proposed, list(found.separates)
