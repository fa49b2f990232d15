"""A whole self-calibration: supports, motions, recordings, solution, checks."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np
from rclpy.action import ActionClient
from shoecal_msgs.action import Calibrate, Plan, ReachSupport

from shoecal_core.calibration.calibration import Calibration
from shoecal_core.calibration.settings import CalibrationSettings
from shoecal_core.calibration.tolerances import Tolerances
from shoecal_core.errors import FileError, ShoecalError
from shoecal_core.model.double_support import DoubleSupport
from shoecal_core.model.robot import Robot
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.recording.session import Session
from shoecal_core.sensing.shoe import Shoe
from shoecal_core.settings import Settings, setting
from shoecal_ros.calibrator import solving_work
from shoecal_ros.calibrator.recorder import Recorder
from shoecal_ros.common.actions import NotSentError, do_action
from shoecal_ros.common.conversions import support_to_ros
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.runtime import until
from shoecal_ros.common.worker import Work, Worker
from shoecal_ros.inputs.stillness import Stillness

R = TypeVar("R")
FEEDBACK_S = 0.2
REACH_ACTION, PLAN_ACTION = "robot/reach_support", "shoe/plan"

DRAW_SHARE, SOLVE_SHARE = 0.04, 0.06
"""Of the whole job's progress."""
REACH_SHARE, PLAN_SHARE = 0.1, 0.3
"""Of one support's progress."""


@dataclass(frozen=True)
class JobSettings(Settings):
    """What a self-calibration does where nothing else is asked for; wall-clock times."""

    supports: int = setting(5, "", "double supports to visit", minimum=2, maximum=100)
    train: int = setting(3, "", "of them used for the fit, the others test it", minimum=2)
    seed: int = setting(1, "", "draws the supports, and which of them train", minimum=0)
    motion: str = setting("landmarks", "", "motion in each support, on the planner's menu")
    sessions_dir: str = setting(
        "~/.ros/shoecal/sessions", "", "folder that takes one folder a self-calibration"
    )
    planner_file: str = setting(
        "", "", "the planner's parameter file; empty: the configuration's nodes/planner.yaml"
    )
    apply_warned: bool = setting(
        False, "", "also apply a calibration whose checks passed with warnings"
    )
    lead_s: float = setting(
        0.5, "s", "robot's time recorded before the motion is sent", minimum=0.0, maximum=60.0
    )
    still_speed: float = setting(
        0.01, "rad/s", "a robot whose joints are slower stands still", minimum=1e-4
    )
    still_time: float = setting(
        0.5, "s", "robot's time for which it must be so", minimum=0.05, maximum=60.0
    )
    still_resolution: float = setting(
        0.004, "rad", "changes up to this are the encoders', not the robot's", minimum=0.0
    )
    still_timeout_s: float = setting(30.0, "s", "in which it must stand still", minimum=1.0)
    reach_timeout_s: float = setting(
        600.0, "s", "in which a support must be reached; a person may have to", minimum=1.0
    )
    motion_timeout_s: float = setting(
        900.0, "s", "in which a motion must be planned and done", minimum=1.0
    )


class Site(Protocol):
    """What a job needs of its node."""

    files: RobotFiles
    robot: Robot
    shoe: Shoe
    job_settings: JobSettings
    fit_settings: CalibrationSettings
    tolerances: Tolerances
    planning: PlannerSettings
    recorder: Recorder
    stillness: Stillness
    reach_client: ActionClient
    plan_client: ActionClient

    @property
    def armed(self) -> bool:
        """Whether the robot may be moved."""

    @property
    def now_ns(self) -> int:
        """The node's time [ns]."""

    def input_problem(self) -> str:
        """What is wrong with joint angles or voltages, and its cure; empty when all is well."""

    def wake(self) -> None:
        """Let waiting jobs look again."""


@dataclass(frozen=True)
class Request:
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
        calibration: found, None before it is; applied by whoever runs the job.
        state: how far it is by now.
    """

    def __init__(
        self,
        site: Site,
        request: Request,
        feedback: Callable[[Calibrate.Feedback], None],
        canceled: Callable[[], bool],
    ) -> None:
        self.request = request
        self.session: Path | None = None
        self.calibration: Calibration | None = None
        self.state = Calibrate.Feedback(run_id=request.run_id, supports=request.supports)
        self._site = site
        self._feedback = feedback
        self._canceled = canceled
        self._index = 0
        self._told = ("", 0.0)

    async def run(self) -> Calibration:
        """Do it all but apply the result.

        Raises:
            RefusedError: with a code of Calibrate.Result, when it ends otherwise.
        """
        request, site = self.request, self._site
        site.recorder.problem = ""
        self._check()
        worker = Worker(site.wake)
        try:
            self._tell("drawing", 0.0, "drawing double supports")
            supports = await self._worked(
                worker.do(
                    solving_work.draw, site.files, site.planning, request.supports, request.seed
                ),
                Calibrate.Result.SUPPORT_FAILED,
            )
            session = self._make_session()
            training = _training(request)
            for index, support in enumerate(supports):
                self._index = index + 1
                await self._record(session, support, "train" if index in training else "test")
            self._tell("solving", 1.0 - SOLVE_SHARE, "finding gains and offsets")
            self.calibration = await self._worked(
                worker.do(
                    solving_work.solve,
                    session.folder,
                    site.fit_settings,
                    site.tolerances,
                    site.now_ns,
                ),
                Calibrate.Result.SOLVE_FAILED,
                moving=False,
            )
            return self.calibration
        finally:
            site.recorder.abandon()
            worker.close()

    def tell_applying(self) -> None:
        """Tell that the calibration found is being applied."""
        self._tell("applying", 1.0, "checking and applying the calibration")

    # Steps

    def _make_session(self) -> Session:
        site = self._site
        folder = Path(site.job_settings.sessions_dir).expanduser()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            session = Session.create(
                folder / self.request.run_id,
                site.robot.path, site.robot.urdf, site.shoe.path,
                seed=self.request.seed,
            )  # fmt: skip
        except OSError as error:
            problem = FileError(folder, f"cannot be made ({error.strerror}); correct sessions_dir")
            raise RefusedError(Calibrate.Result.RECORDING_FAILED, str(problem)) from error
        except ShoecalError as error:
            raise RefusedError(Calibrate.Result.RECORDING_FAILED, str(error)) from error
        self.session = session.folder
        return session

    async def _record(self, session: Session, support: DoubleSupport, hint: str) -> None:
        """Reach a support, stand still, move, and record that."""
        place = f"dx {support.dx:g} m, dy {support.dy:g} m, dtheta {support.dtheta:g} rad"
        self._tell("reaching", self._share(0.0), place)
        goal = ReachSupport.Goal(support=support_to_ros(support))
        settings = self._site.job_settings
        reached = await self._action(
            self._site.reach_client,
            REACH_ACTION,
            goal,
            lambda told: self._tell("reaching", self._share(REACH_SHARE * told.progress), place),
            settings.reach_timeout_s,
            Calibrate.Result.SUPPORT_FAILED,
        )
        self._require(
            reached, Calibrate.Result.SUPPORT_FAILED, f"support {self._index} ({place}) not reached"
        )
        await self._stand_still()
        await self._move(session, support, hint)

    async def _stand_still(self) -> None:
        site = self._site
        site.stillness.restart()
        await until(
            lambda: site.stillness.still or self._interrupted, site.job_settings.still_timeout_s
        )
        self._check()
        if not site.stillness.still:
            raise RefusedError(
                Calibrate.Result.SUPPORT_FAILED,
                f"the robot does not stand still within {site.job_settings.still_timeout_s:g} s; "
                "stop what else moves it, or raise still_speed",
            )

    async def _move(self, session: Session, support: DoubleSupport, hint: str) -> None:
        """Plan and do the motion; what is recorded is the motion, not the planning."""
        site, settings = self._site, self._site.job_settings
        site.recorder.stand_by()
        moved = await self._action(
            site.plan_client,
            PLAN_ACTION,
            Plan.Goal(motion=settings.motion, send=True),
            partial(self._hear_motion, session, support, hint),
            settings.motion_timeout_s,
            Calibrate.Result.MOTION_FAILED,
        )
        self._require(moved, Calibrate.Result.MOTION_FAILED, f"motion {self._index} not done")
        try:
            site.recorder.stop()
        except ShoecalError as error:
            raise RefusedError(Calibrate.Result.RECORDING_FAILED, str(error)) from error

    def _hear_motion(
        self, session: Session, support: DoubleSupport, hint: str, told: Plan.Feedback
    ) -> None:
        recorder = self._site.recorder
        if told.phase != "moving":
            share = REACH_SHARE + PLAN_SHARE * told.progress
            self._tell("planning", self._share(share), f"landmark {told.landmark}")
            return
        if not recorder.recording and not recorder.problem:
            try:
                recorder.start(session.new_run(self._site.job_settings.motion, support, hint=hint))
            except ShoecalError as error:
                recorder.problem = str(error)
        share = REACH_SHARE + PLAN_SHARE + (1.0 - REACH_SHARE - PLAN_SHARE) * told.progress
        self._tell("moving", self._share(share), f"landmark {told.landmark}")

    # Waiting

    async def _worked(self, work: Work[R], code: int, *, moving: bool = True) -> R:
        """What a worker's work gives; once nothing is to move, only cancelling ends it."""
        stop = (lambda: self._interrupted) if moving else self._canceled
        await until(lambda: work.done or stop(), _FOREVER_S)
        self._check_canceled()
        if moving:
            self._check()
        try:
            return work.result()
        except ShoecalError as error:
            raise RefusedError(code, str(error)) from error

    async def _action(
        self,
        client: ActionClient,
        name: str,
        goal: Any,
        feedback: Callable[[Any], None],
        timeout_s: float,
        code: int,
    ) -> Any:
        """The result of an action, which is cancelled where the job must end."""
        try:
            result = await do_action(
                client,
                name,
                goal,
                feedback=feedback,
                stop=lambda: self._interrupted,
                timeout_s=timeout_s,
            )
        except NotSentError as error:
            self._check()
            raise RefusedError(code, str(error)) from error
        except ShoecalError as error:
            raise RefusedError(code, str(error)) from error
        self._check()
        return result

    @property
    def _interrupted(self) -> bool:
        site = self._site
        return (
            self._canceled()
            or not site.armed
            or bool(site.recorder.problem)
            or bool(site.input_problem())
        )

    def _check(self) -> None:
        """End the job where it must.

        Raises:
            RefusedError: with the reason.
        """
        site, codes = self._site, Calibrate.Result
        self._check_canceled()
        if not site.armed:
            raise RefusedError(
                codes.NOT_ARMED, "not armed: call the service shoe/arm with data true first"
            )
        if site.recorder.problem:
            raise RefusedError(codes.RECORDING_FAILED, site.recorder.problem)
        problem = site.input_problem()
        if problem:
            raise RefusedError(codes.STALE_INPUT, problem)

    def _check_canceled(self) -> None:
        if self._canceled():
            raise RefusedError(Calibrate.Result.CANCELED, "cancelled; what was recorded stays")

    def _require(self, result: Any, code: int, what: str) -> None:
        if not result.success:
            raise RefusedError(code, f"{what}: {result.message}")

    # Telling

    def _share(self, of_support: float) -> float:
        each = (1.0 - DRAW_SHARE - SOLVE_SHARE) / self.request.supports
        return DRAW_SHARE + each * (self._index - 1 + of_support)

    def _tell(self, stage: str, progress: float, message: str) -> None:
        self.state = Calibrate.Feedback(
            run_id=self.request.run_id,
            stage=stage,
            support=self._index,
            supports=self.request.supports,
            progress=float(progress),
            message=message,
        )
        told, at = self._told
        now = time.monotonic()
        if stage == told and now - at < FEEDBACK_S:
            return
        self._told = (stage, now)
        self._feedback(self.state)


def _training(request: Request) -> set[int]:
    """Which supports train, drawn."""
    generator = np.random.default_rng([request.seed, 2])
    chosen = generator.choice(request.supports, size=request.train, replace=False)
    return {int(index) for index in chosen}


_FOREVER_S = 1e9
