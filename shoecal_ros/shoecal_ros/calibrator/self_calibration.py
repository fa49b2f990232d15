"""Action `shoe/calibrate` and service `shoe/self_calibrate`: one self-calibration at a time."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from shoecal_msgs.action import Calibrate
from shoecal_msgs.srv import SelfCalibrate

from shoecal_core.screening.verdict import list_reasons
from shoecal_ros.calibrator.calibration_job import CalibrationJob, CalibrationRequest
from shoecal_ros.calibrator.calibration_server import CalibrationServer
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.job import new_run_id
from shoecal_ros.calibrator.job_settings import MOST_SUPPORTS
from shoecal_ros.common.actions import finish, logged
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.conversions import calibration_to_ros
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.refusal import RefusedError, faults_refused


class SelfCalibrationServer:
    """Takes requests, runs the job, and has applied what it found where that may be applied."""

    title = "a self-calibration"

    def __init__(self, node: CalibratorBase, calibrations: CalibrationServer) -> None:
        self._node, self._calibrations = node, calibrations
        node.jobs.append(self)
        self._job: CalibrationJob | None = None
        node.serve(SelfCalibrate, "shoe/self_calibrate", self._self_calibrate)
        self._server = ActionServer(
            node, Calibrate, "shoe/calibrate", self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )  # fmt: skip

    @property
    def busy(self) -> bool:
        """Whether a self-calibration is under way."""
        return self._job is not None

    @property
    def run_id(self) -> str:
        """Of the one under way; empty while there is none."""
        return "" if self._job is None else self._job.request.run_id

    @property
    def condition(self) -> Condition | None:
        """How far it is, for diagnostics; None while there is none."""
        if self._job is None:
            return None
        state = self._job.state
        reported = {
            "run_id": state.run_id,
            "stage": state.stage,
            "support": f"{state.support} of {state.supports}",
            "progress": f"{state.progress:.2f}",
        }
        return Condition(Level.OK, "self-calibration under way", reported)

    def _begin(
        self,
        goal: Any,
        feedback: Callable[[Calibrate.Feedback], None],
        canceled: Callable[[], bool] | None,
    ) -> CalibrationJob:
        node = self._node
        node.refuse_second_job()
        defaults = node.job_settings
        supports, train = goal.supports or defaults.supports, goal.train or defaults.train
        if not 2 <= train <= supports <= MOST_SUPPORTS:
            raise RefusedError(
                Calibrate.Result.BAD_GOAL,
                f"{train} of {supports} double supports to train with; take at least 2, at most "
                f"all of them, and no more than {MOST_SUPPORTS} in all",
            )
        seed = goal.seed if goal.seed >= 0 else defaults.seed
        self._calibrations.problem = None
        node.listen_for_recording()
        self._job = CalibrationJob(
            node,
            CalibrationRequest(new_run_id(), supports, train, seed),
            logged(node, feedback, lambda reported: (reported.stage, reported.support)),
            canceled,
        )
        return self._job

    async def _do(self, job: CalibrationJob, result: Calibrate.Result) -> None:
        """Run a job to its end, and apply what it found where that may be applied."""
        node = self._node
        try:
            with faults_refused(node.log, Calibrate.Result.FAILED):
                calibration = await job.run()
                # Also one that is refused comes back whole, and stays in the session's folder.
                result.calibration = calibration_to_ros(calibration, node.origin)
                job.report_applying()
                await self._calibrations.apply_found(
                    calibration, job.request.run_id, warned=node.job_settings.apply_warned
                )
            result.success = True
            result.message = f"'{calibration.id}' in force: {list_reasons(calibration.reasons)}"
        except RefusedError as refusal:
            node.log(Level.WARN, f"self-calibration ended: {refusal}")
            raise
        finally:
            result.session = str(job.session or "")
            self._end()

    def _end(self) -> None:
        self._job = None
        self._node.listen_live()

    async def _execute(self, goal: ServerGoalHandle) -> Calibrate.Result:
        result = Calibrate.Result()
        try:
            with faults_refused(self._node.log, Calibrate.Result.FAILED):
                job = self._begin(
                    goal.request, goal.publish_feedback, lambda: goal.is_cancel_requested
                )
                result.run_id = job.request.run_id
                await self._do(job, result)
        except RefusedError as refusal:
            result.error_code, result.message = refusal.code, str(refusal)
            if not result.run_id:
                self._node.log(Level.WARN, f"self-calibration not begun: {refusal}")
        finish(goal, result, canceled=Calibrate.Result.CANCELED)
        return result

    async def _self_calibrate(
        self, request: SelfCalibrate.Request, response: SelfCalibrate.Response
    ) -> SelfCalibrate.Response:
        try:
            with faults_refused(self._node.log, Calibrate.Result.FAILED):
                job = self._begin(request, lambda _: None, None)
                try:
                    await job.begin()
                except RefusedError:
                    self._end()
                    raise
        except RefusedError as refusal:
            response.error_code, response.message = refusal.code, str(refusal)
            return response
        self._node.start(partial(self._do_alone, job))
        response.accepted, response.run_id = True, job.request.run_id
        response.message = (
            "started; diagnostics show how far it is; disarm (shoe/arm false) to stop"
        )
        return response

    async def _do_alone(self, job: CalibrationJob) -> None:
        try:
            with faults_refused(self._node.log, Calibrate.Result.FAILED):
                await self._do(job, Calibrate.Result())
        except RefusedError as refusal:
            reported = f"self-calibration {job.request.run_id} ended: {refusal}"
            values = {"error_code": str(refusal.code)}
            self._calibrations.problem = Problem(Code.SELF_CALIBRATION_ENDED, reported, values)
