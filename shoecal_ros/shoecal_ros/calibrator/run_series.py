"""Recording one run after another: reach a double support, stand still, move."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from shoecal_msgs.action import Plan, ReachSupport

from shoecal_core.errors import ShoecalError
from shoecal_core.files import system_error
from shoecal_core.planning.motion_sets import TRAIN, PlannedRun
from shoecal_core.recording.session import Session
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.calibrator.calibrator_base import PLAN_ACTION, REACH_ACTION, CalibratorBase
from shoecal_ros.calibrator.job import Codes, Job
from shoecal_ros.calibrator.proposals import planned_as
from shoecal_ros.common.conversions import support_to_ros
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.waiting import aside, until

LONGEST_NAME = 255
"""Of a file or folder [characters]."""
REACH_SHARE, PLAN_SHARE = 0.1, 0.3
"""Of one run's progress."""

SeriesProgress = Callable[[str, int, float, str], None]
"""Takes the stage (reaching, planning, moving), the run from 1 on, how much of all runs is done
(0 to 1), and a line for a person."""


class NoSessionNameError(ShoecalError):
    """Anything but the plain name of a folder."""


def session_folder(sessions_dir: str, name: str) -> Path:
    """Folder of a session by its name: no request names a file.

    Raises:
        NoSessionNameError: for anything but a plain name.
    """
    sessions = Path(sessions_dir).expanduser()
    plain = name.isprintable() and len(name) <= LONGEST_NAME and "/" not in name
    if not plain or name in {"", ".", ".."}:
        raise NoSessionNameError(
            f"a session is named by its folder's name in {sessions}, without any path; put it "
            "there (a link does), or use the command shoecal with it"
        )
    return sessions / name


async def make_session(node: CalibratorBase, name: str, seed: int) -> Session:
    """A new session's folder in `sessions_dir`.

    Raises:
        RefusedError: when it cannot be made.
    """
    folder = Path(node.job_settings.sessions_dir).expanduser()

    def make() -> Session:
        folder.mkdir(parents=True, exist_ok=True)
        return Session.create(
            folder / name, node.robot.path, node.robot.urdf, node.shoe.path, seed=seed
        )

    try:
        return await aside(make)
    except OSError as error:
        problem = system_error(folder, error, "cannot be made", "correct sessions_dir")
        raise RefusedError(Codes.RECORDING_FAILED, str(problem)) from error
    except ShoecalError as error:
        raise RefusedError(Codes.RECORDING_FAILED, str(error)) from error


class RunSeries:
    """Records runs into a session; what was recorded stays whatever ends the job."""

    def __init__(self, job: Job, session: Session, reported: SeriesProgress) -> None:
        self._job = job
        self._node = job.node
        self._session = session
        self._report_all = reported
        self._index = self._count = 0

    async def record(
        self,
        runs: Sequence[PlannedRun],
        enough: Callable[[], Awaitable[bool]] | None = None,
    ) -> None:
        """Do them in their order.

        Args:
            runs: all of them.
            enough: asked after each run that trains, whether those that would still train are left
                out; None: they are not.

        Raises:
            RefusedError: when it must end before.
        """
        left = list(runs)
        self._index, self._count = 0, len(left)
        while left:
            run = left.pop(0)
            self._index += 1
            await self._reach(run.support)
            await self._stand_still()
            await self._move(run)
            trains = any(one.hint == TRAIN for one in left)
            if enough is not None and run.hint == TRAIN and trains and await enough():
                left = [one for one in left if one.hint != TRAIN]
                self._count = self._index + len(left)

    async def _reach(self, support: DoubleSupport) -> None:
        place = str(support)
        self._report("reaching", 0.0, place)
        reached = await self._job.done(
            self._node.reach_client,
            REACH_ACTION,
            ReachSupport.Goal(support=support_to_ros(support), run_id=self._node.run_id),
            lambda reported: self._report("reaching", REACH_SHARE * reported.progress, place),
            self._node.job_settings.reach_timeout_s,
            Codes.SUPPORT_FAILED,
        )
        _require(reached, Codes.SUPPORT_FAILED, f"support {self._index} ({place}) not reached")

    async def _stand_still(self) -> None:
        node, job = self._node, self._job
        node.stillness.restart()
        await until(
            lambda: node.stillness.still or job.interrupted, node.job_settings.still_timeout_s
        )
        job.check()
        if not node.stillness.still:
            raise RefusedError(
                Codes.SUPPORT_FAILED,
                f"the robot does not stand still within {node.job_settings.still_timeout_s:g} s; "
                "stop what else moves it, or raise still_speed",
            )

    async def _move(self, run: PlannedRun) -> None:
        """Plan and do the motion; what is recorded is the motion, not the planning."""
        recorder = self._node.recorder
        recorder.stand_by()
        moved = await self._job.done(
            self._node.plan_client,
            PLAN_ACTION,
            Plan.Goal(motion=planned_as(run.motion), send=True, run_id=self._node.run_id),
            partial(self._hear_motion, run),
            self._node.job_settings.motion_timeout_s,
            Codes.MOTION_FAILED,
        )
        _require(moved, Codes.MOTION_FAILED, f"motion {self._index} ({run.motion}) not done")
        recorder.stop()
        try:
            await aside(recorder.finish)
        except ShoecalError as error:
            raise RefusedError(Codes.RECORDING_FAILED, str(error)) from error

    def _hear_motion(self, run: PlannedRun, reported: Plan.Feedback) -> None:
        recorder, place = self._node.recorder, f"{run.motion}, landmark {reported.landmark}"
        if reported.phase != "moving":
            self._report("planning", REACH_SHARE + PLAN_SHARE * reported.progress, place)
            return
        if not recorder.recording and not recorder.problem:
            recorder.start(partial(self._session.new_run, run.motion, run.support, hint=run.hint))
        share = REACH_SHARE + PLAN_SHARE + (1.0 - REACH_SHARE - PLAN_SHARE) * reported.progress
        self._report("moving", share, place)

    def _report(self, stage: str, of_run: float, message: str) -> None:
        self._report_all(stage, self._index, (self._index - 1 + of_run) / self._count, message)


def _require(result: Any, code: int, what: str) -> None:
    if not result.success:
        raise RefusedError(code, f"{what}: {result.message}")
