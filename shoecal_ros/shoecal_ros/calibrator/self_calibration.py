"""Action `shoe/calibrate` and service `shoe/self_calibrate`: one self-calibration at a time."""

from __future__ import annotations

from functools import partial
from typing import Any

from shoecal_msgs.action import Calibrate
from shoecal_msgs.srv import SelfCalibrate

from shoecal_core.screening.verdict import list_reasons
from shoecal_ros.calibrator.calibration_job import CalibrationJob
from shoecal_ros.calibrator.calibration_server import CalibrationServer
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.job_server import JobServer
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.conversions import calibration_to_ros
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.refusal import RefusedError, faults_refused


class SelfCalibrationServer(JobServer[CalibrationJob]):
    """Takes requests, runs the job, and has applied what it found where that may be applied."""

    def __init__(self, node: CalibratorBase, calibrations: CalibrationServer) -> None:
        super().__init__(node, Calibrate, "shoe/calibrate", "self-calibration", CalibrationJob)
        self._calibrations = calibrations
        node.serve(SelfCalibrate, "shoe/self_calibrate", self._self_calibrate)

    @property
    def condition(self) -> Condition | None:
        """How far it is, for diagnostics; None while there is none."""
        if self._job is None:
            return None
        return Condition(Level.OK, "self-calibration under way", self._job.figures)

    def _begin(self, *args: Any) -> CalibrationJob:
        job = super()._begin(*args)
        self._calibrations.problem = None
        return job

    async def _work(self, job: CalibrationJob, result: Any) -> str:
        node = self._node
        calibration = await job.run()
        # Also one that is refused comes back whole, and stays in the session's folder.
        result.calibration = calibration_to_ros(calibration, node.origin)
        job.feed("applying", 1.0, "checking and applying the calibration")
        await self._calibrations.apply_found(
            calibration, job.run_id, warned=node.job_settings.apply_warned
        )
        found = f"'{calibration.id}' in force: {list_reasons(calibration.reasons)}"
        return f"{found}; {job.summary}" if job.summary else found

    async def _self_calibrate(
        self, request: SelfCalibrate.Request, response: SelfCalibrate.Response
    ) -> SelfCalibrate.Response:
        try:
            with faults_refused(self._node.log, Calibrate.Result.FAILED):
                job = self._begin(request, lambda _: None, None)
                try:
                    await job.begin()
                except BaseException:
                    self._end()
                    raise
        except RefusedError as refusal:
            response.error_code, response.message = refusal.code, str(refusal)
            return response
        self._node.start(partial(self._do_alone, job))
        response.accepted, response.run_id = True, job.run_id
        response.message = (
            "started; diagnostics show how far it is; disarm (shoe/arm false) to stop"
        )
        return response

    async def _do_alone(self, job: CalibrationJob) -> None:
        try:
            with faults_refused(self._node.log, Calibrate.Result.FAILED):
                await self._do(job, Calibrate.Result())
        except RefusedError as refusal:
            reported = f"self-calibration {job.run_id} ended: {refusal}"
            values = {"error_code": str(refusal.code)}
            self._calibrations.problem = Problem(Code.SELF_CALIBRATION_ENDED, reported, values)
