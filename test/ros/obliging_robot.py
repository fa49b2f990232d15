"""A robot that offers all that a self-calibration needs, and waves its arms for a motion."""

from __future__ import annotations

from builtin_interfaces.msg import Duration
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.task import Future
from shoecal_msgs.action import Plan, ReachSupport
from std_msgs.msg import Bool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from ros.standing_robot import StandingRobot
from ros.world import World
from shoecal_core.robot.double_support import DoubleSupport
from shoecal_ros.calibrator.calibrator_base import PLAN_ACTION, REACH_ACTION
from shoecal_ros.common import qos

WAVE_S = 12.0
"""Of its own time."""


class ObligingRobot(StandingRobot):
    """Arms itself, reaches every support, and does one motion.

    Attributes:
        run_ids: of the goals that were asked for.
    """

    def __init__(self, world: World, support: DoubleSupport) -> None:
        super().__init__(world, support)
        self.modelled = True
        self.pace = 4
        self.run_ids: list[str] = []
        self._done = Future()
        self._listened = Future()
        self._end_ns = 0
        self._armed = world.node.create_publisher(Bool, "shoe/armed", qos.LATCHED)
        self._armed.publish(Bool(data=True))
        self._commands = world.node.create_publisher(JointTrajectory, "joint_trajectory", 10)
        self._servers = [
            ActionServer(
                world.node, kind, name, do, cancel_callback=lambda _: CancelResponse.ACCEPT
            )
            for kind, name, do in (
                (ReachSupport, REACH_ACTION, self._reach),
                (Plan, PLAN_ACTION, self._move),
            )
        ]

    def _tell(self) -> None:
        super()._tell()
        if self._commands.get_subscription_count() and not self._listened.done():
            self._listened.set_result(None)
        if self.waving and self.stamp_ns >= self._end_ns and not self._done.done():
            self._done.set_result(None)

    def _reach(self, goal: ServerGoalHandle) -> ReachSupport.Result:
        self.run_ids.append(goal.request.run_id)
        support = goal.request.support
        self.step_to(DoubleSupport(support.dx, support.dy, support.dtheta))
        goal.succeed()
        return ReachSupport.Result(success=True)

    async def _move(self, goal: ServerGoalHandle) -> Plan.Result:
        self.run_ids.append(goal.request.run_id)
        # Whoever records it has been heard of.
        await self._listened
        point = JointTrajectoryPoint(positions=[0.0], time_from_start=Duration(sec=1))
        self._commands.publish(JointTrajectory(joint_names=["LShoulderPitch"], points=[point]))
        goal.publish_feedback(Plan.Feedback(phase="moving"))
        self.waving = True
        self._done = Future()
        self._end_ns = self.stamp_ns + round(WAVE_S * 1e9)
        await self._done
        self.waving = False
        goal.succeed()
        return Plan.Result(success=True)
