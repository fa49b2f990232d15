"""One goal of the action `shoe/plan`: plan, check, send, follow."""

from __future__ import annotations

from functools import partial

import numpy as np
from rclpy.action.server import ServerGoalHandle
from shoecal_msgs.action import Plan

from shoecal_core.arrays import FloatArray
from shoecal_core.errors import NameNotFoundError
from shoecal_core.planning.motion_catalogue import MOTION_KINDS, motion_kind
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_ros.common.actions import Pacing
from shoecal_ros.common.conversions import trajectory_to_ros
from shoecal_ros.common.names import short_name
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.common.worker import Work
from shoecal_ros.planner import planning_work
from shoecal_ros.planner.execution import CURE, Execution
from shoecal_ros.planner.following import DeflectionCompensation
from shoecal_ros.planner.order import Mover, Order

IDLE_CHUNKS = 3
"""Streamed parts in a row that may bring no progress."""


class PlanJob:
    """Does one goal; the result is filled as far as the job comes.

    Attributes:
        name: for the log.
        execution: what moves the robot.
    """

    def __init__(self, mover: Mover, goal: ServerGoalHandle, result: Plan.Result) -> None:
        self._mover = mover
        self._goal = goal
        self._result = result
        self._pacing = Pacing()
        self.name = f"motion '{short_name(goal.request.motion)}'"
        order = Order(goal.request.send, lambda: bool(goal.is_cancel_requested), self._feed)
        self.execution = Execution(mover, order)

    async def run(self) -> None:
        """Plan, and send and follow where asked to.

        Raises:
            RefusedError: when it ends otherwise than done.
        """
        request = self._goal.request
        self._check_request()
        self.execution.measured()
        self.execution.check_ready()
        if request.stream:
            await self._stream()
        else:
            await self._whole()

    def _check_request(self) -> None:
        request = self._goal.request
        try:
            kind = motion_kind(request.motion)
        except NameNotFoundError as error:
            raise RefusedError(Plan.Result.BAD_GOAL, str(error)) from error
        problem = ""
        if request.stream and not request.send:
            problem = "a motion is streamed to the robot: ask to send it"
        elif request.stream and not kind.streams:
            reported = ", ".join(name for name, kind in MOTION_KINDS.items() if kind.streams)
            problem = (
                f"motion '{request.motion}' is planned as a whole and cannot be streamed; "
                f"ask without stream, or for one of: {reported}"
            )
        if problem:
            raise RefusedError(Plan.Result.BAD_GOAL, problem)

    async def _whole(self) -> None:
        mover, execution, request = self._mover, self.execution, self._goal.request
        start = execution.measured()
        motion = await execution.planned(
            lambda: mover.worker.do(
                planning_work.plan, mover.files, mover.planning, start, request.motion
            )
        )
        trajectory = execution.commanded(motion)
        self._result.trajectory = trajectory_to_ros(trajectory)
        self._result.landmark_distance = motion.path.nearest.tolist()
        if request.send:
            execution.check_ready()
            execution.check_start(start)
            await execution.follow(trajectory, motion)

    async def _stream(self) -> None:
        """Part by part, each planned from rest to rest, from the joint angles measured between.

        Motors give under load: the robot comes to rest a little off its command. So that
        what is measured follows what was checked, commands are ahead of the plan by that much,
        at most `give`.
        """
        mover, execution = self._mover, self.execution
        targets: FloatArray | None = None
        nearest: list[float] = []
        times, positions = [np.zeros(0)], [np.zeros((0, len(execution.names)))]
        legs = mover.robot.legs
        names = [mover.robot.joint_names[index] for index in legs]
        give = DeflectionCompensation(names, mover.moving.give, IDLE_CHUNKS)
        while targets is None or len(targets):
            start = execution.measured()
            chunk = await execution.planned(partial(self._start_chunk, start, targets))
            nearest += chunk.nearest.tolist()
            if chunk.motion is None:
                break
            execution.check_start(start)
            trajectory = execution.commanded(chunk.motion, give.ahead)
            await execution.follow(trajectory, chunk.motion)
            ended = execution.measured()
            problem = give.learn(chunk.motion.positions[:, legs], start[legs], ended[legs])
            if problem:
                execution.hold(ended)
                raise RefusedError(Plan.Result.NOT_FOLLOWED, f"stopped: {problem}; {CURE}")
            targets = chunk.targets
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

    def _feed(self, phase: str, progress: float, landmark: int) -> None:
        if self._pacing.due(phase):
            self._goal.publish_feedback(
                Plan.Feedback(phase=phase, progress=float(progress), landmark=landmark)
            )
