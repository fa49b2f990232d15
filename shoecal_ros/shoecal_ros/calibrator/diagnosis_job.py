"""A whole diagnosis: record, diagnose, run the proposed motion, diagnose again."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import cast

from shoecal_msgs.action import Diagnose

from shoecal_core.errors import ShoecalError
from shoecal_core.files import sha256
from shoecal_core.planning.standard import STANDARD
from shoecal_core.recording.errors import SessionError
from shoecal_core.recording.session import Session
from shoecal_ros.calibrator import diagnosis_work
from shoecal_ros.calibrator.diagnosis_work import WrittenDiagnosis
from shoecal_ros.calibrator.job import Job, JobContext
from shoecal_ros.calibrator.proposals import by_hand, how_to_go_on, proposal
from shoecal_ros.calibrator.run_series import RunSeries, make_session
from shoecal_ros.common.actions import Pacing
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.waiting import aside
from shoecal_ros.common.worker import Worker

DRAW_PART, DIAGNOSE_PART = 0.2, 1.0
"""Of the whole job's progress, where one run counts 1."""


@dataclass(frozen=True)
class DiagnosisRequest:
    """What is asked for.

    Attributes:
        run_id: names the job, and the folder of a session that it records.
        session: an existing one; None: a new one is recorded.
        motions: to record; empty: the standard set, with a session none.
        run_proposed: also run the motion that the diagnosis proposes, and diagnose again.
        seed: draws the double supports.
    """

    run_id: str
    session: Path | None
    motions: tuple[str, ...]
    run_proposed: bool
    seed: int

    @property
    def records(self) -> bool:
        """Whether runs are recorded before the diagnosis."""
        return self.session is None or bool(self.motions)

    @property
    def moves(self) -> bool:
        """Whether the robot may have to move."""
        return self.records or self.run_proposed


class RunningDiagnosis:
    """One diagnosis; how far it came stays to be seen when it fails.

    Attributes:
        request: what is asked for.
        session: folder of the recording, None before there is one.
        found: the last diagnosis, None before there is one.
        state: how far it is by now.
    """

    def __init__(
        self,
        site: JobContext,
        request: DiagnosisRequest,
        feedback: Callable[[Diagnose.Feedback], None],
        canceled: Callable[[], bool],
    ) -> None:
        self.request = request
        self.session = request.session
        self.found: WrittenDiagnosis | None = None
        self.state = Diagnose.Feedback(run_id=request.run_id)
        self._site = site
        self._job = Job(site, canceled)
        self._feedback = feedback
        self._pacing = Pacing()
        self._progress = _Progress(_parts(request))
        self._worker: Worker | None = None

    async def run(self) -> str:
        """Do it all; what came out, in a line for a person.

        Raises:
            RefusedError: with a code of Diagnose.Result, when it ends otherwise.
        """
        request, site = self.request, self._site
        await self._check_goal()
        site.recorder.problem = ""
        if request.moves:
            await self._job.begin()
        self._worker = worker = Worker(site.wake)
        try:
            if request.records:
                await self._record(worker, request.motions)
            first = await self._diagnose(worker)
            alone = request.run_proposed and first.proposed and not by_hand(first.proposed)
            if not alone:
                return self._reported(first.verdict, first)
            await self._record(worker, (first.proposed,))
            second = await self._diagnose(worker)
            verdicts = f"{first.verdict}, after {first.proposed} {second.verdict}"
            return self._reported(verdicts, second)
        finally:
            site.recorder.abandon()
            worker.close()
            await aside(site.recorder.settle)

    def close(self) -> None:
        """End what its worker is doing: the node ends."""
        if self._worker is not None:
            self._worker.close()

    # Steps

    async def _check_goal(self) -> None:
        """Refuse what cannot be done before anything is.

        Raises:
            RefusedError: BAD_GOAL, with the cure.
        """
        request = self.request

        def check(folder: Path) -> None:
            session = Session.open(folder)
            if request.moves:
                self._require_own(session)

        try:
            for name in request.motions:
                proposal(name)
            if request.session is not None:
                await aside(partial(check, request.session))
        except ShoecalError as error:
            raise RefusedError(Diagnose.Result.BAD_GOAL, str(error)) from error

    def _require_own(self, session: Session) -> None:
        """Runs of this robot on these shoes belong into sessions of theirs; FileError else."""
        robot, shoe = self._site.robot, self._site.shoe
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
        request, site = self.request, self._site
        self._report("drawing", 0.0, "drawing double supports")
        runs = await self._job.worked(
            worker.do(
                diagnosis_work.runs_to_record,
                site.files, site.planning, motions, request.seed, self.session,
            ),
            Diagnose.Result.SUPPORT_FAILED,
        )  # fmt: skip
        self._progress.next()
        if self.session is None:
            session = await make_session(site, request.run_id, request.seed)
        else:
            session = await self._reopened(self.session)
        self.session = session.folder
        self.state.runs = len(runs)
        await RunSeries(self._job, session, self._report_recording).record(runs)
        self._progress.next()

    async def _reopened(self, folder: Path) -> Session:
        try:
            return await aside(partial(Session.open, folder))
        except ShoecalError as error:
            raise RefusedError(Diagnose.Result.RECORDING_FAILED, str(error)) from error

    async def _diagnose(self, worker: Worker) -> WrittenDiagnosis:
        """Diagnose what there is; only cancelling ends it."""
        assert self.session is not None, "recorded or named"
        site = self._site
        self._report("diagnosing", 0.0, "looking for causes of the gap")
        self.found = await self._job.worked(
            worker.do(
                diagnosis_work.diagnose_session,
                self.session, site.diagnosis_settings, site.tolerances,
            ),
            Diagnose.Result.DIAGNOSIS_FAILED,
            moving=False,
            progress=self._hear_diagnosis,
        )  # fmt: skip
        self._progress.next()
        return self.found

    # Reporting

    def _reported(self, verdicts: str, found: WrittenDiagnosis) -> str:
        """The verdicts, and how to go on."""
        if not found.proposed:
            return verdicts
        assert self.session is not None, "diagnosed"
        return f"{verdicts}; {how_to_go_on(found.proposed, self.session)}"

    def _report_recording(self, stage: str, run: int, share: float, message: str) -> None:
        self.state.run = run
        self._report(stage, share, message)

    def _hear_diagnosis(self, reported: object) -> None:
        doing, share = cast(tuple[str, float], reported)
        self._report("diagnosing", share, doing)

    def _report(self, phase: str, share: float, message: str) -> None:
        """Report how far the part at hand is."""
        state = self.state
        state.phase, state.message = phase, message
        state.progress = self._progress.at(share)
        if self._pacing.due(phase):
            self._feedback(state)


class _Progress:
    """Of a job made of parts, one after another."""

    def __init__(self, parts: Sequence[float]) -> None:
        self._parts = list(parts)
        self._index = 0

    def next(self) -> None:
        """The part at hand is done."""
        self._index += 1

    def at(self, share: float) -> float:
        """Of the whole (0 to 1), with this share of the part at hand done."""
        parts, index = self._parts, self._index
        return float((sum(parts[:index]) + share * parts[index]) / sum(parts))


def _parts(request: DiagnosisRequest) -> list[float]:
    """How long each part takes, where a run counts 1: drawing and runs, diagnosis."""
    parts = []
    if request.records:
        parts += [DRAW_PART, float(len(request.motions) or len(STANDARD))]
    parts.append(DIAGNOSE_PART)
    if request.run_proposed:
        parts += [DRAW_PART, 1.0, DIAGNOSE_PART]
    return parts
