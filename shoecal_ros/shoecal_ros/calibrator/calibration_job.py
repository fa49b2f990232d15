"""A whole self-calibration: supports, motions, recordings, solution, checks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from shoecal_msgs.action import Calibrate

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.planning.standard import TEST, TRAIN, PlannedRun, standard_runs
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.calibrator import solving_work
from shoecal_ros.calibrator.job import Job, JobContext
from shoecal_ros.calibrator.job_settings import STANDARD_SET
from shoecal_ros.calibrator.run_series import RunSeries, make_session
from shoecal_ros.common.actions import Pacing
from shoecal_ros.common.waiting import aside
from shoecal_ros.common.worker import Worker

DRAW_SHARE, SOLVE_SHARE = 0.04, 0.06
"""Of the whole job's progress."""


@dataclass(frozen=True)
class CalibrationRequest:
    """What is asked for.

    Attributes:
        run_id: names the job and its session's folder.
        supports, train: how many.
        seed: draws what is drawn.
    """

    run_id: str
    supports: int
    train: int
    seed: int


class CalibrationJob:
    """One self-calibration; how far it came stays to be seen when it fails.

    Attributes:
        request: what is asked for.
        session: folder of the recording, None before there is one.
        state: how far it is by now.
    """

    def __init__(
        self,
        site: JobContext,
        request: CalibrationRequest,
        feedback: Callable[[Calibrate.Feedback], None],
        canceled: Callable[[], bool] | None,
    ) -> None:
        self.request = request
        self.session: Path | None = None
        self.state = Calibrate.Feedback(run_id=request.run_id, supports=request.supports)
        self._site = site
        self._job = Job(site, canceled)
        self._feedback = feedback
        self._pacing = Pacing()

    async def begin(self) -> None:
        """See that it can begin: the robot is armed, and all that it needs comes.

        Raises:
            RefusedError: with a code of Calibrate.Result.
        """
        self._site.recorder.problem = ""
        await self._job.begin()

    async def run(self) -> Calibration:
        """Do it all but apply the result.

        Raises:
            RefusedError: with a code of Calibrate.Result, when it ends otherwise.
        """
        site = self._site
        await self.begin()
        worker = Worker(site.wake)
        try:
            runs = await self._draw(worker)
            # The standard set comes back to a support, to lift each foot.
            self.state.supports = len(runs)
            session = await make_session(site, self.request.run_id, self.request.seed)
            self.session = session.folder
            await RunSeries(self._job, session, self._report_recording).record(runs)
            return await self._solve(worker, session.folder)
        finally:
            site.recorder.abandon()
            worker.close()
            await aside(site.recorder.settle)

    def report_applying(self) -> None:
        """Report that the calibration found is being applied."""
        self._report("applying", 1.0, "checking and applying the calibration")

    # Steps

    async def _draw(self, worker: Worker) -> list[PlannedRun]:
        request, site = self.request, self._site
        self._report("drawing", 0.0, "drawing double supports")
        supports = await self._job.worked(
            worker.do(solving_work.draw, site.files, site.planning, request.supports, request.seed),
            Calibrate.Result.SUPPORT_FAILED,
        )
        if site.job_settings.motion == STANDARD_SET:
            neutral = DoubleSupport(*map(float, site.robot.support_range.neutral))
            return list(standard_runs(supports, neutral))
        training = _training(request)
        return [
            PlannedRun(support, site.job_settings.motion, TRAIN if index in training else TEST)
            for index, support in enumerate(supports)
        ]

    async def _solve(self, worker: Worker, folder: Path) -> Calibration:
        site = self._site
        self._report("solving", 1.0 - SOLVE_SHARE, "finding gains and offsets")
        return await self._job.worked(
            worker.do(
                solving_work.solve,
                folder,
                site.fit_settings,
                site.tolerances,
                site.now_ns,
                site.manual,
            ),
            Calibrate.Result.SOLVE_FAILED,
            moving=False,
        )

    # Reporting

    def _report_recording(self, stage: str, run: int, share: float, message: str) -> None:
        self.state.support = run
        self._report(stage, DRAW_SHARE + (1.0 - DRAW_SHARE - SOLVE_SHARE) * share, message)

    def _report(self, stage: str, progress: float, message: str) -> None:
        state = self.state
        state.stage, state.progress, state.message = stage, float(progress), message
        if self._pacing.due(stage):
            self._feedback(state)


def _training(request: CalibrationRequest) -> set[int]:
    """Which supports train, drawn."""
    generator = np.random.default_rng([request.seed, 2])
    chosen = generator.choice(request.supports, size=request.train, replace=False)
    return {int(index) for index in chosen}
