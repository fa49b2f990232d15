"""Action `shoe/diagnose`: one diagnosis at a time."""

from __future__ import annotations

from pathlib import Path

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from shoecal_msgs.action import Diagnose

from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.diagnosis_job import DiagnosisRequest, RunningDiagnosis
from shoecal_ros.calibrator.job import new_run_id
from shoecal_ros.calibrator.session_folder import NoSessionNameError, session_folder
from shoecal_ros.common.actions import finish, logged
from shoecal_ros.common.codes import Code
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.refusal import RefusedError, faults_refused

MOST_MOTIONS = 100


class DiagnosisServer:
    """Takes goals, runs the job, and reports what it found."""

    title = "a diagnosis"

    def __init__(self, node: CalibratorBase) -> None:
        self._node = node
        node.jobs.append(self)
        self._job: RunningDiagnosis | None = None
        self._last = Condition(Level.OK, "none yet")
        self._server = ActionServer(
            node, Diagnose, "shoe/diagnose", self._execute,
            cancel_callback=lambda _: CancelResponse.ACCEPT,
        )  # fmt: skip

    @property
    def run_id(self) -> str:
        """Of the one under way; empty while there is none."""
        return "" if self._job is None else self._job.state.run_id

    @property
    def condition(self) -> Condition:
        """How far it is, or how the last one ended, for diagnostics."""
        if self._job is None:
            return self._last
        state = self._job.state
        reported = {
            "run_id": state.run_id,
            "phase": state.phase,
            "run": f"{state.run} of {state.runs}",
            "progress": f"{state.progress:.2f}",
        }
        return Condition(Level.OK, "under way", reported)

    def close(self) -> None:
        """End what is under way: the node ends."""
        if self._job is not None:
            self._job.close()

    async def _execute(self, goal: ServerGoalHandle) -> Diagnose.Result:
        result = Diagnose.Result()
        try:
            with faults_refused(self._node.log, Diagnose.Result.FAILED):
                await self._do(goal, result)
        except RefusedError as refusal:
            result.error_code, result.message = refusal.code, str(refusal)
            if not result.run_id:
                self._node.log(Level.WARN, f"diagnosis not begun: {refusal}")
        finish(goal, result, canceled=Diagnose.Result.CANCELED)
        return result

    async def _do(self, goal: ServerGoalHandle, result: Diagnose.Result) -> None:
        """Run a job to its end; the result is filled as far as it comes."""
        node = self._node
        node.refuse_second_job()
        request = self._request(goal.request)
        job = self._job = RunningDiagnosis(
            node,
            request,
            logged(node, goal.publish_feedback, lambda reported: (reported.phase, reported.run)),
            lambda: bool(goal.is_cancel_requested),
        )
        result.run_id = request.run_id
        if request.moves:
            node.listen_for_recording()
        try:
            with faults_refused(node.log, Diagnose.Result.FAILED):
                result.message = await job.run()
            result.success = True
            self._last = Condition(Level.OK, result.message)
        except RefusedError as refusal:
            values = {"error_code": str(refusal.code)}
            reported = f"ended: {refusal}"
            self._last = Condition(Level.WARN, reported, values, Code.DIAGNOSIS_ENDED)
            node.log(Level.WARN, f"diagnosis ended: {refusal}")
            raise
        finally:
            self._job = None
            node.listen_live()
            _fill(result, job)

    def _request(self, goal: Diagnose.Goal) -> DiagnosisRequest:
        if len(goal.motions) > MOST_MOTIONS:
            raise RefusedError(
                Diagnose.Result.BAD_GOAL,
                f"{len(goal.motions)} motions; record at most {MOST_MOTIONS} at a time",
            )
        return DiagnosisRequest(
            run_id=new_run_id(),
            session=self._folder(goal.session) if goal.session else None,
            motions=tuple(goal.motions),
            run_proposed=goal.run_proposed,
            seed=goal.seed if goal.seed >= 0 else self._node.job_settings.seed,
        )

    def _folder(self, session: str) -> Path:
        """Of a session in `sessions_dir`; RefusedError for anything but a plain name."""
        try:
            return session_folder(self._node.job_settings.sessions_dir, session)
        except NoSessionNameError as error:
            raise RefusedError(Diagnose.Result.BAD_GOAL, str(error)) from error


def _fill(result: Diagnose.Result, job: RunningDiagnosis) -> None:
    """What there is by now, also of a job that ended before its time."""
    result.session = str(job.session or "")
    found = job.found
    if found is not None:
        result.verdict, result.json, result.report = found.verdict, found.json, str(found.report)
        result.proposed, result.separates = found.proposed, list(found.separates)
