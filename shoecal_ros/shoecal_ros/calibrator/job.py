"""What jobs that may move the robot share: they wait for work and actions, and end where they must.

Reasons to end carry the codes of `Calibrate.Result`; those of `Diagnose.Result` are the same.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

from rclpy.action import ActionClient
from shoecal_msgs.action import Calibrate

from shoecal_core.errors import ShoecalError
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.common.actions import NotSentError, Pacing, do_action
from shoecal_ros.common.health import Level
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.waiting import aside, until
from shoecal_ros.common.worker import Work, Worker

R = TypeVar("R")
Codes = Calibrate.Result
ARMED_WITHIN_S = 2.0
"""The word that the robot is armed may come so much later than the request that followed it."""


def new_run_id() -> str:
    """Names a job, and the folder of the session it records."""
    return datetime.now(UTC).strftime("%Y%m%dT%H%M%S%f")[:-3]


class Job:
    """One job of a calibrator; how far it came stays to be seen when it fails.

    Attributes:
        node: whose job it is.
        session: folder of the recording, None before there is one.
        moves: whether the robot may have to move.
        state: how far it is by now: feedback of its action.
        STAGE, RUN: names of its fields for the stage and the run at hand.
    """

    STAGE, RUN = "stage", "run"

    def __init__(
        self,
        node: CalibratorBase,
        state: Any,
        canceled: Callable[[], bool] | None,
        feedback: Callable[[Any], None] = lambda _: None,
    ) -> None:
        """A job begins.

        Args:
            node: whose job it is.
            state: feedback of its action, with the id of the run.
            canceled: whether it is asked to end; None where that cannot be asked for: then
                disarming ends it also while nothing moves.
            feedback: takes the state whenever that is due.
        """
        self.node, self.state = node, state
        self.session: Path | None = None
        self.moves = True
        self._feedback = feedback
        self._pacing = Pacing()
        self._logged: tuple[str, int] | None = None
        self._worker: Worker | None = None
        self._alone = canceled is None
        self._canceled = canceled or (lambda: False)
        self._disarmings = node.arming.disarmings
        self._end: RefusedError | None = None

    @property
    def run_id(self) -> str:
        """Names the job, and the folder of a session that it records."""
        return str(self.state.run_id)

    @property
    def figures(self) -> dict[str, str]:
        """How far it is, for diagnostics."""
        state = self.state
        return {
            "run_id": self.run_id,
            self.STAGE: getattr(state, self.STAGE),
            self.RUN: f"{getattr(state, self.RUN)} of {getattr(state, f'{self.RUN}s')}",
            "progress": f"{state.progress:.2f}",
        }

    def feed(self, stage: str, progress: float, message: str, run: int | None = None) -> None:
        """Report how far it is; in the log, a line whenever another stage or run begins.

        Args:
            stage: at hand.
            progress: of the whole, 0 to 1.
            message: a line for a person.
            run: at hand, from 1 on; None: as before.
        """
        state = self.state
        setattr(state, self.STAGE, stage)
        if run is not None:
            setattr(state, self.RUN, run)
        state.progress, state.message = float(progress), message
        if not self._pacing.due(stage):
            return
        step = stage, getattr(state, self.RUN)
        if step != self._logged:
            self._logged = step
            self.node.log(Level.OK, f"{stage} {step[1]}: {message}")
        self._feedback(state)

    async def with_worker(self, do: Callable[[Worker], Awaitable[R]]) -> R:
        """What is done with a worker of the job's own; nothing is recorded any more afterwards."""
        recorder = self.node.recorder
        self._worker = worker = Worker(self.node.wake)
        try:
            return await do(worker)
        finally:
            recorder.abandon()
            worker.close()
            await aside(recorder.settle)

    def close(self) -> None:
        """End what its worker is doing: the node ends."""
        if self._worker is not None:
            self._worker.close()

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
        return self.node.arming.armed and not self._disarmed

    @property
    def _disarmed(self) -> bool:
        return self.node.arming.disarmings != self._disarmings

    async def begin(self) -> None:
        """See whether the robot may be moved, now that the job begins.

        Raises:
            RefusedError: with the reason why not.
        """
        self.node.recorder.problem = ""
        arming = self.node.arming
        await until(lambda: arming.armed or self._disarmed or self._canceled(), ARMED_WITHIN_S)
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
        node = self.node
        self.check_canceled()
        self._check_lapsed()
        if not self._armed:
            raise RefusedError(
                Codes.NOT_ARMED,
                "disarmed since the job began: start it again"
                if node.arming.armed
                else "not armed: call the service shoe/arm with data true first",
            )
        if node.recorder.problem:
            raise RefusedError(Codes.RECORDING_FAILED, node.recorder.problem)
        if problem := node.input_problem():
            raise RefusedError(Codes.STALE_INPUT, problem.message)

    def _check_lapsed(self) -> None:
        if self.node.arming.lapsed:
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
