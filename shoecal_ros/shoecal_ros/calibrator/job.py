"""What jobs that may move the robot share: they wait for work and actions, and end where they must.

Reasons to end carry the codes of `Calibrate.Result`; those of `Diagnose.Result` are the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import UTC, datetime
from typing import Any, Protocol, TypeVar

from rclpy.action import ActionClient
from shoecal_msgs.action import Calibrate

from shoecal_core.diagnosis.settings import DiagnosisSettings
from shoecal_core.error_sources.tolerances import Tolerances
from shoecal_core.errors import ShoecalError
from shoecal_core.estimation.calibration import Calibration
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.robot import Robot
from shoecal_core.screening.settings import CalibrationSettings
from shoecal_core.shoe.shoe import Shoe
from shoecal_ros.calibrator.job_settings import JobSettings
from shoecal_ros.calibrator.recorder import Recorder
from shoecal_ros.common.actions import NotSentError, do_action
from shoecal_ros.common.codes import Problem
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.waiting import until
from shoecal_ros.common.worker import Work
from shoecal_ros.inputs.stillness import Stillness

R = TypeVar("R")
Codes = Calibrate.Result
ARMED_WITHIN_S = 2.0
"""The word that the robot is armed may come so much later than the request that followed it."""


def new_run_id() -> str:
    """Names a job, and the folder of the session it records."""
    return datetime.now(UTC).strftime("%Y%m%dT%H%M%S%f")[:-3]


class JobContext(Protocol):
    """What a job needs of its node."""

    files: RobotFiles
    robot: Robot
    shoe: Shoe
    job_settings: JobSettings
    fit_settings: CalibrationSettings
    tolerances: Tolerances
    diagnosis_settings: DiagnosisSettings
    planning: PlannerSettings
    manual: Calibration | None
    recorder: Recorder
    stillness: Stillness
    reach_client: ActionClient
    plan_client: ActionClient

    @property
    def armed(self) -> bool:
        """Whether the robot may be moved."""

    @property
    def disarmings(self) -> int:
        """How often that was taken back."""

    @property
    def lapsed(self) -> bool:
        """Whether who armed the robot has fallen silent."""

    @property
    def now_ns(self) -> int:
        """The node's time [ns]."""

    @property
    def run_id(self) -> str:
        """Of the job under way."""

    def input_problem(self) -> Problem | None:
        """What is wrong with joint angles or voltages, and its cure; None when all is well."""

    def wake(self) -> None:
        """Let waiting jobs look again."""


class Job:
    """One job on its site.

    Attributes:
        site: its node.
    """

    def __init__(self, site: JobContext, canceled: Callable[[], bool] | None) -> None:
        """A job begins.

        Args:
            site: its node.
            canceled: whether it is asked to end; None where that cannot be asked for: then
                disarming ends it also while nothing moves.
        """
        self.site = site
        self._alone = canceled is None
        self._canceled = canceled or (lambda: False)
        self._disarmings = site.disarmings
        self._end: RefusedError | None = None

    @property
    def interrupted(self) -> bool:
        """Whether nothing may move any more."""
        try:
            self.check()
        except RefusedError:
            return True
        return False

    @property
    def _armed(self) -> bool:
        """Armed, and never disarmed since the job began: arming again is not meant for it."""
        return self.site.armed and not self._disarmed

    @property
    def _disarmed(self) -> bool:
        return self.site.disarmings != self._disarmings

    async def begin(self) -> None:
        """See whether the robot may be moved, now that the job begins.

        Raises:
            RefusedError: with the reason why not.
        """
        await until(lambda: self.site.armed or self._disarmed or self._canceled(), ARMED_WITHIN_S)
        self.check()

    def check(self) -> None:
        """End the job where nothing may move any more.

        The first reason stays: by the time the robot has stopped, what was missing may be back.

        Raises:
            RefusedError: with the reason.
        """
        try:
            self._check_now()
        except RefusedError as refusal:
            self._end = self._end or refusal
        if self._end is not None:
            raise self._end

    def _check_now(self) -> None:
        site = self.site
        self.check_canceled()
        self._check_lapsed()
        if not self._armed:
            raise RefusedError(
                Codes.NOT_ARMED,
                "disarmed since the job began: start it again"
                if site.armed
                else "not armed: call the service shoe/arm with data true first",
            )
        if site.recorder.problem:
            raise RefusedError(Codes.RECORDING_FAILED, site.recorder.problem)
        if problem := site.input_problem():
            raise RefusedError(Codes.STALE_INPUT, problem.message)

    def _check_lapsed(self) -> None:
        if self.site.lapsed:
            raise RefusedError(
                Codes.NOT_ARMED,
                "the planner, which armed the robot, has fallen silent: start it again and arm",
            )

    def check_canceled(self) -> None:
        """End the job where that is asked for; RefusedError then."""
        if self._canceled():
            reported = "cancelled, what was recorded stays; start another when you want"
            raise RefusedError(Codes.CANCELED, reported)

    async def worked(
        self,
        work: Work[R],
        code: int,
        *,
        moving: bool = True,
        progress: Callable[[object], None] = lambda _: None,
    ) -> R:
        """What a worker's work gives.

        Args:
            work: under way.
            code: of its failure.
            moving: whether the robot is to move; else only who may stop the job ends it.
            progress: takes what the work reports meanwhile.
        """

        def over() -> bool:
            if work.progress is not None:
                progress(work.progress)
            return work.done or (self.interrupted if moving else stopped())

        def stopped() -> bool:
            return self._canceled() or (self._alone and self._disarmed)

        await until(over, math.inf)
        self.check_canceled()
        if moving or stopped():
            self.check()
        try:
            return work.result()
        except ShoecalError as error:
            raise RefusedError(code, str(error)) from error

    async def done(
        self,
        client: ActionClient,
        name: str,
        goal: Any,
        feedback: Callable[[Any], None],
        timeout_s: float,
        code: int,
    ) -> Any:
        """The result of an action, which is cancelled where the job must end.

        Args:
            client, name, goal, feedback, timeout_s: as `do_action`.
            code: where the action's server does not do its part.
        """
        try:
            result = await do_action(
                client,
                name,
                goal,
                feedback=feedback,
                stop=lambda: self.interrupted,
                timeout_s=timeout_s,
            )
        except NotSentError as error:
            self.check()
            raise RefusedError(code, str(error)) from error
        except ShoecalError as error:
            self._check_lapsed()
            raise RefusedError(code, str(error)) from error
        self.check()
        return result
