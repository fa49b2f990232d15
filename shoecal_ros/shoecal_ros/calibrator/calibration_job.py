"""A whole self-calibration: supports, motions, recordings, solution, checks."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from shoecal_msgs.action import Calibrate

from shoecal_core.estimation.calibration import Calibration
from shoecal_core.planning.motion_sets import PlannedRun
from shoecal_core.screening.settings import JOINT
from shoecal_ros.calibrator import job_work
from shoecal_ros.calibrator.calibrator_base import CalibratorBase
from shoecal_ros.calibrator.job import Job
from shoecal_ros.calibrator.job_settings import MOST_SUPPORTS
from shoecal_ros.calibrator.run_series import RunSeries, make_session
from shoecal_ros.common.health import Level
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.worker import Worker

DRAW_SHARE, SOLVE_SHARE = 0.04, 0.06
"""Of the whole job's progress."""


class CalibrationJob(Job):
    """One self-calibration."""

    RUN = "support"

    def __init__(
        self,
        node: CalibratorBase,
        goal: Any,
        run_id: str,
        feedback: Callable[[Any], None],
        canceled: Callable[[], bool] | None,
    ) -> None:
        """It has not begun.

        Args:
            node: whose job it is.
            goal: of the action or the service.
            run_id: names the job and its session's folder.
            feedback, canceled: as those of `Job`.

        Raises:
            RefusedError: BAD_GOAL, with the cure.
        """
        defaults = node.job_settings
        self._supports = supports = goal.supports or defaults.supports
        self._train = train = goal.train or defaults.train
        if not 2 <= train <= supports <= MOST_SUPPORTS:
            raise RefusedError(
                Calibrate.Result.BAD_GOAL,
                f"{train} of {supports} double supports to train with; take at least 2, at most "
                f"all of them, and no more than {MOST_SUPPORTS} in all",
            )
        self._seed = goal.seed if goal.seed >= 0 else defaults.seed
        self._target = goal.target or defaults.target_m
        _require_target(goal.target, self._target, node.fit_settings.method)
        self.summary = ""
        state = Calibrate.Feedback(run_id=run_id, supports=supports)
        super().__init__(node, state, canceled, feedback)

    async def run(self) -> Calibration:
        """Do it all but apply the result.

        Raises:
            RefusedError: with a code of Calibrate.Result, when it ends otherwise.
        """
        await self.begin()
        return await self.with_worker(self._found)

    # Steps

    async def _found(self, worker: Worker) -> Calibration:
        runs = await self._draw(worker)
        # A set may have more runs than there are double supports, or fewer.
        self.state.supports = len(runs)
        session = await make_session(self.node, self.run_id, self._seed)
        self.session = session.folder
        series = RunSeries(self, session, self._report_recording)
        enough = partial(self._enough, worker, session.folder) if self._target else None
        await series.record(runs, enough)
        return await self._solve(worker, session.folder)

    async def _draw(self, worker: Worker) -> list[PlannedRun]:
        node = self.node
        self.feed("drawing", 0.0, "drawing double supports")
        return await self.worked(
            worker.do(
                job_work.calibration_runs,
                node.files, node.planning, node.job_settings.motion,
                self._supports, self._train, self._seed,
            ),
            Calibrate.Result.SUPPORT_FAILED,
        )  # fmt: skip

    async def _enough(self, worker: Worker, folder: Path) -> bool:
        """Whether the training runs recorded so far reach the target."""
        node = self.node
        self.feed("solving", self.state.progress, "looking how good the runs are by now")
        reached = await self.worked(
            worker.do(job_work.reached, folder, node.fit_settings, node.tolerances, node.manual),
            Calibrate.Result.SOLVE_FAILED,
        )
        enough = reached.cop <= self._target
        end = "reached" if enough else "not reached"
        self.summary = f"target {1e3 * self._target:g} mm {end}: {reached.message}"
        node.log(Level.OK, self.summary)
        self.feed("solving", self.state.progress, self.summary)
        return enough

    async def _solve(self, worker: Worker, folder: Path) -> Calibration:
        node = self.node
        self.feed("solving", 1.0 - SOLVE_SHARE, "finding gains and offsets")
        return await self.worked(
            worker.do(
                job_work.solve,
                folder, node.fit_settings, node.tolerances, node.now_ns, node.manual,
            ),
            Calibrate.Result.SOLVE_FAILED,
            moving=False,
        )  # fmt: skip

    def _report_recording(self, stage: str, run: int, share: float, message: str) -> None:
        progress = DRAW_SHARE + (1.0 - DRAW_SHARE - SOLVE_SHARE) * share
        self.feed(stage, progress, message, run)


def _require_target(asked: float, target: float, method: str) -> None:
    """RefusedError where no target can be had, with the cure."""
    if not (math.isfinite(asked) and asked >= 0.0):
        raise RefusedError(
            Calibrate.Result.BAD_GOAL,
            f"target {asked:g}: give the expected CoP error of each foot in metres, as 0.003; 0: "
            "as configured",
        )
    if target and method != JOINT:
        raise RefusedError(
            Calibrate.Result.BAD_GOAL,
            f"target {target:g} m: the method {method} does not know the model's errors; use "
            f"calibration.method {JOINT}, or no target",
        )
