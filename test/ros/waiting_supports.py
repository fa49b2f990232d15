"""Supports that are reached by nobody: a job waits for them until a test goes on."""

from __future__ import annotations

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future
from shoecal_msgs.action import ReachSupport

from ros.world import World
from shoecal_ros.calibrator.calibrator_base import REACH_ACTION


class WaitingSupports:
    """Offers `robot/reach_support`; goals end when they are cancelled, or by `fail`."""

    def __init__(self, world: World) -> None:
        self._answer = Future()
        self._server = ActionServer(
            world.node, ReachSupport, REACH_ACTION, self._wait, cancel_callback=self._cancel
        )

    def fail(self) -> None:
        """Answer the goal under way."""
        self._answer.set_result(None)

    def end(self) -> None:
        """Offer it no more."""
        self._server.destroy()

    def _cancel(self, _: object) -> CancelResponse:
        self._answer.set_result(None)
        return CancelResponse.ACCEPT

    async def _wait(self, goal: ServerGoalHandle) -> ReachSupport.Result:
        await self._answer
        self._answer = Future()
        if goal.is_cancel_requested:
            goal.canceled()
        else:
            goal.abort()
        return ReachSupport.Result(message="nobody walks here")
