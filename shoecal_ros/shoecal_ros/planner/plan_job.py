"""One goal of the action `shoe/plan`: plan, check, send, follow."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from rclpy.action.server import ServerGoalHandle
from shoecal_msgs.action import Plan

from shoecal_core.errors import NameNotFoundError, ShoecalError
from shoecal_core.model.joint_trajectory import JointTrajectory
from shoecal_core.model.robot import Robot
from shoecal_core.planning.check import CheckFailedError
from shoecal_core.planning.menu import MENU
from shoecal_core.planning.motion import Motion
from shoecal_core.planning.posture import UnreachableError
from shoecal_core.planning.rolling import PlanningCanceledError, PlanningError, Progress
from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.planning.timing import TimingError
from shoecal_core.settings import Settings, setting
from shoecal_ros.common.conversions import trajectory_to_ros
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.runtime import until
from shoecal_ros.common.worker import Work, Worker
from shoecal_ros.inputs.joints import JointBatch, JointInput
from shoecal_ros.planner import planning_work
from shoecal_ros.planner.arming import Arming
from shoecal_ros.planner.following import Follower, Give, Verdict

FloatArray = NDArray[np.float64]
R = TypeVar("R")

ANSWER_S = 30.0
"""Wall-clock time in which cancelled planning must end."""
FEEDBACK_S = 0.2
IDLE_CHUNKS = 3
"""Streamed parts in a row that may bring no progress."""

_CODES: tuple[tuple[type[ShoecalError], int], ...] = (
    (PlanningCanceledError, Plan.Result.CANCELED),
    (CheckFailedError, Plan.Result.CHECK_FAILED),
    (PlanningError, Plan.Result.INFEASIBLE),
    (UnreachableError, Plan.Result.INFEASIBLE),
    (TimingError, Plan.Result.INFEASIBLE),
    (NameNotFoundError, Plan.Result.BAD_GOAL),
)


@dataclass(frozen=True)
class MovingSettings(Settings):
    """How motions are sent and watched; wall-clock times unless said otherwise."""

    arm_timeout_s: float = setting(
        900.0, "s", "without use for that long it disarms: time to place the robot", minimum=1.0
    )
    stale_s: float = setting(
        0.5, "s", "without joint angles for that long a motion is stopped", minimum=0.01
    )
    follow_error: float = setting(
        0.12, "rad", "a joint farther off its trajectory stops the motion", minimum=1e-3
    )
    follow_late: float = setting(
        1.0, "s", "the robot may trail its trajectory by this (robot's time)", minimum=0.0
    )
    start_error: float = setting(
        0.03, "rad", "a joint that moved farther while planning refuses the motion", minimum=1e-4
    )
    stop_time: float = setting(0.5, "s", "in which a stopped robot comes to rest", minimum=0.05)
    chunk_states: int = setting(8, "states", "planned states of one streamed part", minimum=4)
    give: float = setting(
        0.03, "rad", "most that a standing joint may be behind streamed commands", minimum=1e-3
    )


class Mover(Protocol):
    """What a job needs of its node."""

    robot: Robot
    files: RobotFiles
    planning: PlannerSettings
    moving: MovingSettings
    joints: JointInput
    arming: Arming
    worker: Worker

    def command(self, trajectory: JointTrajectory) -> None:
        """Send a trajectory to the robot."""


class PlanJob:
    """Does one goal; the result is filled as far as the job comes.

    Attributes:
        following: whether the robot is on a trajectory that this job has sent.
    """

    def __init__(self, mover: Mover, goal: ServerGoalHandle, result: Plan.Result) -> None:
        self._mover = mover
        self._goal = goal
        self._result = result
        self.following = False
        self._fed = ("", 0.0)
        robot = mover.robot
        self._moved = [*robot.legs, *(shared.joint for shared in robot.shared)]

    async def run(self) -> None:
        """Plan, and send and follow where asked to.

        Raises:
            RefusedError: when it ends otherwise than done.
        """
        request = self._goal.request
        if request.motion not in MENU:
            error = NameNotFoundError("motion", request.motion, tuple(MENU))
            raise RefusedError(Plan.Result.BAD_GOAL, str(error))
        if request.stream and not request.send:
            raise RefusedError(
                Plan.Result.BAD_GOAL, "a motion is streamed to the robot: ask to send it"
            )
        self._measured()
        self._check_armed()
        if request.stream:
            await self._stream()
        else:
            await self._whole()

    def halt(self) -> None:
        """Stop the robot gently where it is, if it is on its way."""
        latest = self._mover.joints.latest
        if self.following and latest is not None:
            self._hold(latest.angles[0])

    # Ways of doing it

    async def _whole(self) -> None:
        mover, request = self._mover, self._goal.request
        start = self._measured()
        motion = await self._planned(
            lambda: mover.worker.do(
                planning_work.plan, mover.files, mover.planning, start, request.motion
            )
        )
        trajectory = self._commanded(motion)
        self._result.trajectory = trajectory_to_ros(trajectory)
        self._result.landmark_distance = motion.path.nearest.tolist()
        if request.send:
            self._check_start(start)
            await self._follow(trajectory, motion)

    async def _stream(self) -> None:
        """Part by part, each planned from where the robot has come to."""
        mover = self._mover
        targets: FloatArray | None = None
        nearest: list[float] = []
        times, positions = [np.zeros(0)], [np.zeros((0, len(self._moved)))]
        legs = mover.robot.legs
        names = [mover.robot.joint_names[index] for index in legs]
        give = Give(names, mover.moving.give, IDLE_CHUNKS)
        while targets is None or len(targets):
            start = self._measured()
            chunk = await self._planned(partial(self._start_chunk, start, targets))
            self._check_start(start)
            trajectory = self._commanded(chunk.motion, give.ahead)
            await self._follow(trajectory, chunk.motion)
            ended = self._measured()
            problem = give.learn(chunk.motion.positions[:, legs], start[legs], ended[legs])
            if problem:
                self._hold(ended)
                raise RefusedError(Plan.Result.NOT_FOLLOWED, f"stopped: {problem}; {_CURE}")
            targets = chunk.targets
            nearest += chunk.nearest.tolist()
            begin = times[-1][-1] + 1.0 / mover.planning.sample_rate if len(times) > 1 else 0.0
            times.append(begin + trajectory.times)
            positions.append(trajectory.positions)
        whole = JointTrajectory(trajectory.names, np.concatenate(times), np.concatenate(positions))
        self._result.trajectory = trajectory_to_ros(whole)
        self._result.landmark_distance = nearest

    def _start_chunk(
        self, start: FloatArray, targets: FloatArray | None
    ) -> Work[planning_work.Chunk]:
        mover = self._mover
        return mover.worker.do(
            planning_work.plan_chunk, mover.files, mover.planning, start,
            self._goal.request.motion, targets, mover.moving.chunk_states,
        )  # fmt: skip

    # Steps

    async def _planned(self, start: Callable[[], Work[R]]) -> R:
        """What a worker's work gives; the robot may be disarmed, or the goal cancelled."""
        worker = self._mover.worker
        await until(lambda: self._interrupted or not worker.busy, _FOREVER_S)
        self._check_interrupted()
        work = start()
        while not work.done and not self._interrupted:
            await until(lambda: work.done or self._interrupted, FEEDBACK_S)
            if isinstance(work.progress, Progress):
                told = work.progress
                self._feed("planning", told.landmark / max(1, told.landmarks), told.landmark)
        if not work.done:
            worker.cancel()
            await until(lambda: work.done, ANSWER_S)
        self._check_interrupted()
        try:
            return work.result()
        except ShoecalError as error:
            code = next((code for kind, code in _CODES if isinstance(error, kind)), None)
            raise RefusedError(Plan.Result.FAILED if code is None else code, str(error)) from error

    async def _follow(self, trajectory: JointTrajectory, motion: Motion) -> None:
        """Send a trajectory and watch it done; whatever goes wrong stops the robot gently."""
        mover, moving = self._mover, self._mover.moving
        planned = JointTrajectory(motion.joint_names, motion.time, motion.positions)
        seen = self._latest()
        # By the stamps of the joint angles: whose clock they follow does not matter then.
        follower = Follower(planned, int(seen.stamp_ns[0]), moving.follow_error, moving.follow_late)
        # Whoever records the motion begins before it does.
        self._feed("moving", 0.0, 0)
        mover.command(trajectory)
        self.following = True
        while True:
            await self._news(seen)
            if mover.joints.problem:
                # Nobody knows where the robot is: it stops where it was meant to be when seen.
                self._hold(follower.expected(int(seen.stamp_ns[0])))
                raise RefusedError(
                    Plan.Result.NO_JOINT_STATES, f"stopped while moving: {mover.joints.problem}"
                )
            seen = self._latest()
            stamp_ns, angles = int(seen.stamp_ns[0]), seen.angles[0]
            if self._interrupted:
                self._hold(angles)
                self._check_interrupted()
            look = follower.look(stamp_ns, angles)
            if look.verdict is Verdict.LOST:
                self._hold(angles)
                raise RefusedError(
                    Plan.Result.NOT_FOLLOWED,
                    f"stopped: joint '{look.joint}' is {look.error:.3f} rad off its trajectory "
                    f"(follow_error {moving.follow_error:g} rad); {_CURE}",
                )
            landmark = int(
                np.searchsorted(motion.path.switches, look.progress * len(motion.path.states))
            )
            self._feed("moving", look.progress, landmark)
            if look.verdict is Verdict.ARRIVED:
                self.following = False
                return

    async def _news(self, seen: JointBatch) -> None:
        """Wait for other joint angles than those seen, or for a reason to stop."""
        joints = self._mover.joints
        await until(
            lambda: self._interrupted or bool(joints.problem) or joints.latest is not seen,
            _FOREVER_S,
        )

    def _hold(self, angles: FloatArray) -> None:
        robot = self._mover.robot
        # Encoders may show angles a little beyond a limit; no robot takes such a command.
        held = np.clip(robot.from_legs(angles[robot.legs], angles), robot.lower, robot.upper)
        stop = np.array([self._mover.moving.stop_time])
        self._mover.command(JointTrajectory(self._names, stop, held[None, self._moved]))
        self.following = False

    # Small things

    @property
    def _names(self) -> tuple[str, ...]:
        return tuple(self._mover.robot.joint_names[index] for index in self._moved)

    def _commanded(self, motion: Motion, ahead: FloatArray | float = 0.0) -> JointTrajectory:
        """What is sent: the joints that the planner moves; the others stay as they are."""
        robot = self._mover.robot
        legs = motion.positions[:, robot.legs] + ahead
        positions = np.clip(robot.from_legs(legs), robot.lower, robot.upper)
        return JointTrajectory(self._names, motion.time, positions[:, self._moved])

    @property
    def _interrupted(self) -> bool:
        return self._goal.is_cancel_requested or (
            self._goal.request.send and not self._mover.arming.armed
        )

    def _check_interrupted(self) -> None:
        if self._goal.is_cancel_requested:
            raise RefusedError(Plan.Result.CANCELED, "cancelled")
        self._check_armed()

    def _check_armed(self) -> None:
        if self._goal.request.send and not self._mover.arming.armed:
            raise RefusedError(
                Plan.Result.NOT_ARMED, "not armed: call the service shoe/arm with data true first"
            )

    def _measured(self) -> FloatArray:
        angles: FloatArray = self._latest().angles[0]
        return angles

    def _latest(self) -> JointBatch:
        joints = self._mover.joints
        if joints.problem or joints.latest is None:
            raise RefusedError(Plan.Result.NO_JOINT_STATES, joints.problem)
        return joints.latest

    def _check_start(self, start: FloatArray) -> None:
        moved = np.abs(self._measured() - start)[self._moved]
        limit = self._mover.moving.start_error
        if moved.max() > limit:
            raise RefusedError(
                Plan.Result.FAILED,
                f"joint '{self._names[int(np.argmax(moved))]}' moved by {moved.max():.3f} rad "
                f"while the motion was planned (start_error {limit:g} rad); let the robot stand "
                "still and plan again",
            )

    def _feed(self, phase: str, progress: float, landmark: int) -> None:
        now = time.monotonic()
        told, at = self._fed
        if phase == told and now - at < FEEDBACK_S:
            return
        self._fed = (phase, now)
        self._goal.publish_feedback(
            Plan.Feedback(phase=phase, progress=float(progress), landmark=landmark)
        )


_FOREVER_S = 1e9
_CURE = "see that the robot's motors are on and that it listens to joint_trajectory"
