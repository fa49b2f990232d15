"""A whole diagnosis: record, diagnose, run the proposed motion, diagnose again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, cast

from shoecal_msgs.action import Diagnose

from shoecal_core.errors import ShoecalError
from shoecal_core.files import sha256
from shoecal_core.planning.motion_sets import MOTION_SETS, THOROUGH
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import Session
from shoecal_ros.calibrator import job_work
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.job import Job
from shoecal_ros.calibrator.job_work import WrittenDiagnosis
from shoecal_ros.calibrator.proposals import by_hand, how_to_go_on, proposal
from shoecal_ros.calibrator.run_series import (
    NoSessionNameError,
    RunSeries,
    make_session,
    session_folder,
)
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.waiting import aside
from shoecal_ros.common.worker import Worker

MOST_MOTIONS = 100
DRAW_PART, DIAGNOSE_PART = 0.2, 1.0
"""Of the whole job's progress, where one run counts 1."""


class DiagnosisJob(Job):
    """One diagnosis.

    Attributes:
        found: the last diagnosis, None before there is one.
    """

    STAGE = "phase"

    def __init__(
        self,
        node: CalibratorBase,
        goal: Diagnose.Goal,
        run_id: str,
        feedback: Callable[[Any], None],
        canceled: Callable[[], bool] | None,
    ) -> None:
        """It has not begun.

        Args:
            node: whose job it is.
            goal: of the action.
            run_id: names the job, and the folder of a session that it records.
            feedback, canceled: as those of `Job`.

        Raises:
            RefusedError: BAD_GOAL, with the cure.
        """
        if len(goal.motions) > MOST_MOTIONS:
            raise RefusedError(
                Diagnose.Result.BAD_GOAL,
                f"{len(goal.motions)} motions; record at most {MOST_MOTIONS} at a time",
            )
        super().__init__(node, Diagnose.Feedback(run_id=run_id), canceled, feedback)
        settings = node.job_settings
        if goal.session:
            try:
                self.session = session_folder(settings.sessions_dir, goal.session)
            except NoSessionNameError as error:
                raise RefusedError(Diagnose.Result.BAD_GOAL, str(error)) from error
        self.found: WrittenDiagnosis | None = None
        self._goal = goal
        self._motions = tuple(goal.motions)
        self._seed = goal.seed if goal.seed >= 0 else settings.seed
        # Without a session a new one is recorded, without motions the thorough set.
        self._records = self.session is None or bool(self._motions)
        self.moves = self._records or goal.run_proposed
        self._parts, self._part = self._part_lengths(), 0

    async def run(self) -> str:
        """Do it all; what came out, in a line for a person.

        Raises:
            RefusedError: with a code of Diagnose.Result, when it ends otherwise.
        """
        await self._check_goal()
        if self.moves:
            await self.begin()
        return await self.with_worker(self._reported)

    # Steps

    async def _reported(self, worker: Worker) -> str:
        if self._records:
            await self._record(worker, self._motions)
        found = await self._diagnose(worker)
        verdicts = found.verdict
        if self._goal.run_proposed and found.proposed and not by_hand(found.proposed):
            ran = found.proposed
            await self._record(worker, (ran,))
            found = await self._diagnose(worker)
            verdicts += f", after {ran} {found.verdict}"
        if not found.proposed:
            return verdicts
        assert self.session is not None, "diagnosed"
        return f"{verdicts}; {how_to_go_on(found.proposed, self.session)}"

    async def _check_goal(self) -> None:
        """Refuse what cannot be done before anything is.

        Raises:
            RefusedError: BAD_GOAL, with the cure.
        """

        def check(folder: Path) -> None:
            session = Session.open(folder)
            if self.moves:
                self._require_own(session)

        try:
            for name in self._motions:
                proposal(name)
            if self.session is not None:
                await aside(partial(check, self.session))
        except ShoecalError as error:
            raise RefusedError(Diagnose.Result.BAD_GOAL, str(error)) from error

    def _require_own(self, session: Session) -> None:
        """Runs of this robot on these shoes belong into sessions of theirs; FileError else."""
        robot, shoe = self.node.robot, self.node.shoe
        for path, own, digest in (
            (session.robot_yaml, robot.digest, sha256(session.robot_yaml)),
            (session.robot_urdf, robot.urdf_digest, sha256(session.robot_urdf)),
            (session.shoe.path, shoe.digest, session.shoe.digest),
        ):
            if digest != own:
                raise SessionError(
                    path,
                    "is not what this node works with: nothing can be added to the session; name "
                    "none to record a new one, or start the nodes with its files",
                )

    async def _record(self, worker: Worker, motions: Sequence[str]) -> None:
        """Record motions, into a new session where there is none."""
        node = self.node
        self._report("drawing", 0.0, "drawing double supports")
        runs = await self.worked(
            worker.do(
                job_work.runs_to_record,
                node.files, node.planning, motions, self._seed, self.session,
            ),
            Diagnose.Result.SUPPORT_FAILED,
        )  # fmt: skip
        self._part += 1
        if self.session is None:
            session = await make_session(node, self.run_id, self._seed)
        else:
            session = await self._reopened(self.session)
        self.session = session.folder
        self.state.runs = len(runs)
        await RunSeries(self, session, self._report_recording).record(runs)
        self._part += 1

    async def _reopened(self, folder: Path) -> Session:
        try:
            return await aside(partial(Session.open, folder))
        except ShoecalError as error:
            raise RefusedError(Diagnose.Result.RECORDING_FAILED, str(error)) from error

    async def _diagnose(self, worker: Worker) -> WrittenDiagnosis:
        """Diagnose what there is; only cancelling ends it."""
        assert self.session is not None, "recorded or named"
        node = self.node
        self._report("diagnosing", 0.0, "looking for causes of the gap")
        self.found = await self.worked(
            worker.do(
                job_work.diagnose_session,
                self.session, node.diagnosis_settings, node.tolerances,
            ),
            Diagnose.Result.DIAGNOSIS_FAILED,
            moving=False,
            progress=self._hear_diagnosis,
        )  # fmt: skip
        self._part += 1
        return self.found

    # Reporting

    def _report_recording(self, stage: str, run: int, share: float, message: str) -> None:
        self._report(stage, share, message, run)

    def _hear_diagnosis(self, reported: object) -> None:
        doing, share = cast(tuple[str, float], reported)
        self._report("diagnosing", share, doing)

    def _report(self, phase: str, share: float, message: str, run: int | None = None) -> None:
        """Report how far the part at hand is."""
        parts, index = self._parts, self._part
        progress = (sum(parts[:index]) + share * parts[index]) / sum(parts)
        self.feed(phase, progress, message, run)

    def _part_lengths(self) -> list[float]:
        """How long each part takes, where a run counts 1: drawing and runs, diagnosis."""
        parts = []
        if self._records:
            parts += [DRAW_PART, float(len(self._motions) or len(MOTION_SETS[THOROUGH]))]
        parts.append(DIAGNOSE_PART)
        if self._goal.run_proposed:
            parts += [DRAW_PART, 1.0, DIAGNOSE_PART]
        return parts
