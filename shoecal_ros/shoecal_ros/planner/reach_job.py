"""One goal of the action `robot/reach_support` by own steps: plan a step, send it, follow it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from rclpy.action.server import ServerGoalHandle
from shoecal_msgs.action import Plan, ReachSupport

from shoecal_core.errors import ShoecalError
from shoecal_core.planning.steps import StepError, require_steps_left
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.common.actions import Pacing
from shoecal_ros.common.conversions import support_from_ros
from shoecal_ros.common.refusal import RefusedError
from shoecal_ros.planner import planning_work
from shoecal_ros.planner.execution import Execution
from shoecal_ros.planner.order import Mover, Order

_CODES: Mapping[int, int] = {
    Plan.Result.NO_JOINT_STATES: ReachSupport.Result.NO_JOINT_STATES,
    Plan.Result.INFEASIBLE: ReachSupport.Result.UNREACHABLE,
    Plan.Result.CHECK_FAILED: ReachSupport.Result.CHECK_FAILED,
    Plan.Result.NOT_ARMED: ReachSupport.Result.NOT_ARMED,
    Plan.Result.CANCELED: ReachSupport.Result.CANCELED,
    Plan.Result.NOT_FOLLOWED: ReachSupport.Result.NOT_FOLLOWED,
    Plan.Result.TILTED: ReachSupport.Result.TILTED,
    Plan.Result.LOAD_LOST: ReachSupport.Result.LOAD_LOST,
    Plan.Result.SENSORS_STALE: ReachSupport.Result.SENSORS_STALE,
    Plan.Result.HOT_JOINTS: ReachSupport.Result.HOT_JOINTS,
}
"""What refusals of an execution are called here; everything else has failed."""


class ReachJob:
    """Steps to one double support.

    Attributes:
        name: for the log.
        execution: what moves the robot.
    """

    name = "stepping to a double support"

    def __init__(self, mover: Mover, goal: ServerGoalHandle) -> None:
        self._mover = mover
        self._goal = goal
        self._done = 0
        self._pacing = Pacing()
        order = Order(True, lambda: bool(goal.is_cancel_requested), self._feed)
        self.execution = Execution(mover, order)

    async def run(self) -> None:
        """Step until the feet stand there.

        Raises:
            RefusedError: when it ends otherwise than done, with a code of ReachSupport.
        """
        try:
            support = support_from_ros(self._goal.request.support)
        except ShoecalError as error:
            raise RefusedError(ReachSupport.Result.UNREACHABLE, str(error)) from error
        try:
            await self._step_to(support)
        except RefusedError as refusal:
            code = _CODES.get(refusal.code, ReachSupport.Result.FAILED)
            raise RefusedError(code, str(refusal)) from refusal

    async def _step_to(self, support: DoubleSupport) -> None:
        mover, execution = self._mover, self.execution
        while True:
            execution.check_ready()
            start = execution.measured()
            motion = await execution.planned(
                partial(
                    mover.worker.do,
                    planning_work.step, mover.files, mover.planning, start, support,
                )
            )  # fmt: skip
            if motion is None:
                return
            try:
                require_steps_left(self._done, support)
            except StepError as error:
                raise RefusedError(Plan.Result.FAILED, str(error)) from error
            execution.check_start(start)
            await execution.follow(execution.commanded(motion), motion)
            self._done += 1

    def _feed(self, phase: str, progress: float, landmark: int) -> None:
        """The number of steps is not known before: each counts half of what is left."""
        del landmark
        if self._pacing.due(phase):
            steps = self._done + (progress if phase == "moving" else 0.0)
            self._goal.publish_feedback(ReachSupport.Feedback(progress=1.0 - 0.5**steps))
