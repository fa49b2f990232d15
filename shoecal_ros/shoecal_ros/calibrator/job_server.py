"""Actions whose goals are jobs that may move the robot: one of them at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle

from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.job import Job, new_run_id
from shoecal_ros.common.actions import answered
from shoecal_ros.common.health import Level
from shoecal_ros.common.refusal import RefusedError, faults_refused

J = TypeVar("J", bound=Job)


class JobServer(ABC, Generic[J]):
    """Takes goals of one action, runs the job of each, and reports how it ended."""

    def __init__(
        self, node: CalibratorBase, kind: Any, name: str, what: str, make: Callable[..., J]
    ) -> None:
        """No job is under way.

        Args:
            node: that offers the action.
            kind: of action.
            name: relative name.
            what: a job is, for a sentence.
            make: gives the job of a node, a goal, a run's id, feedback and canceled, as
                `CalibrationJob` does; RefusedError for a goal that cannot be.
        """
        self._node, self._kind, self._what, self._make = node, kind, what, make
        self._job: J | None = None
        self._server = ActionServer(
            node, kind, name, self._execute, cancel_callback=lambda _: CancelResponse.ACCEPT
        )

    @abstractmethod
    async def _work(self, job: J, result: Any) -> str:
        """Do a job, filling its result as far as it comes; what came out, for a person."""

    @property
    def busy(self) -> bool:
        """Whether a job is under way."""
        return self._job is not None

    def close(self) -> None:
        """End what is under way: the node ends."""
        if self._job is not None:
            self._job.close()

    def _begin(
        self,
        goal: Any,
        feedback: Callable[[Any], None],
        canceled: Callable[[], bool] | None,
    ) -> J:
        node = self._node
        node.refuse_second_job()
        job = self._make(node, goal, new_run_id(), feedback, canceled)
        if job.moves:
            node.listen_for_recording()
        self._job = job
        node.begin_job(f"a {self._what}", job.run_id, moves=job.moves)
        return job

    def _end(self) -> None:
        self._job = None
        self._node.end_job()

    async def _do(self, job: J, result: Any) -> str:
        """Run a job to its end; RefusedError where that is not what was asked for."""
        node = self._node
        try:
            with faults_refused(node.log, result.FAILED):
                return await self._work(job, result)
        except RefusedError as refusal:
            node.log(Level.WARN, f"{self._what} ended: {refusal}")
            raise
        finally:
            result.session = str(job.session or "")
            self._end()

    async def _execute(self, goal: ServerGoalHandle) -> Any:
        result = self._kind.Result()

        async def do() -> str:
            try:
                with faults_refused(self._node.log, result.FAILED):
                    job = self._begin(
                        goal.request, goal.publish_feedback, lambda: bool(goal.is_cancel_requested)
                    )
                    result.run_id = job.run_id
                    return await self._do(job, result)
            except RefusedError as refusal:
                if not result.run_id:
                    self._node.log(Level.WARN, f"{self._what} not begun: {refusal}")
                raise

        return await answered(goal, result, do)
