"""Node `planner`: plans whole-body motions, sends them when armed, and watches them done."""

from __future__ import annotations

import math
import time
from typing import Any, TypeVar

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.duration import Duration
from sensor_msgs.msg import Imu, JointState, Temperature
from shoecal_msgs.action import Plan, ReachSupport
from shoecal_msgs.msg import ShoeState, ShoeVoltages
from std_msgs.msg import Bool
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMsg

from shoecal_core.planning.settings import PlannerSettings
from shoecal_core.robot.joint_trajectory import JointTrajectory
from shoecal_core.robot.kinematics import Kinematics
from shoecal_ros.common import qos
from shoecal_ros.common.actions import answered
from shoecal_ros.common.codes import Code, Problem
from shoecal_ros.common.conversions import trajectory_to_ros
from shoecal_ros.common.health import Condition, Level
from shoecal_ros.common.names import short_name
from shoecal_ros.common.node import ShoecalNode
from shoecal_ros.common.process import run
from shoecal_ros.common.refusal import RefusedError, faults_refused
from shoecal_ros.common.robot_files import RobotFiles
from shoecal_ros.common.waiting import until
from shoecal_ros.common.worker import Worker
from shoecal_ros.inputs.imu import ImuInput
from shoecal_ros.inputs.joints import JointInput
from shoecal_ros.inputs.robot_time import RobotTime
from shoecal_ros.inputs.shoe_reports import ShoeReports
from shoecal_ros.inputs.temperatures import TemperatureInput
from shoecal_ros.planner import heat, planning_work
from shoecal_ros.planner.arming import Arming
from shoecal_ros.planner.commanders import Commanders
from shoecal_ros.planner.execution import Execution
from shoecal_ros.planner.listeners import Listeners
from shoecal_ros.planner.plan_job import PlanJob
from shoecal_ros.planner.reach_job import ReachJob
from shoecal_ros.planner.settings import MovingSettings
from shoecal_ros.planner.watch import Senses
from shoecal_ros.planner.watched import watched

R = TypeVar("R", Plan.Result, ReachSupport.Result)

REACH = "robot/reach_support"
"""The action that own steps answer."""
STATE_S = 1.0
"""Wall-clock time in which `shoe/state`, ten times a second, reports that a job began or ended."""
LAST_WORDS = Duration(seconds=1)
"""Wall-clock time that the robot gets to hear the last commands."""


class PlannerNode(ShoecalNode):
    """One motion at a time; cancelling and disarming always win."""

    def __init__(self) -> None:
        super().__init__("planner")
        self.files = self.settings(RobotFiles)
        self.planning = self.settings(PlannerSettings, "planning.")
        self.moving = self.settings(MovingSettings)
        self.robot = self.files.load_robot()
        self.kinematics = Kinematics(self.robot)
        senders = self.peers.expect_one_sender("joint_states")
        self.joints = JointInput(self.robot, self.moving.stale_s, self.awake, senders=senders)
        self.robot_time = RobotTime(simulated=self.simulated)
        self.arming = Arming(self.moving.arm_timeout_s, time.monotonic)
        self.worker = Worker(self.wake)
        self._prepared = self.worker.do(planning_work.prepare, self.files, self.planning)
        self._busy = False
        self._execution: Execution | None = None
        self._command = self.create_publisher(JointTrajectoryMsg, "joint_trajectory", qos.COMMAND)
        self.listeners = Listeners(self, self._command)
        self._commanders = Commanders(self, self._command, self.moving.other_commanders)
        self._armed = self.create_publisher(Bool, "shoe/armed", qos.ARMED)
        self.peers.alone.add(self._armed.topic_name)
        self._armed.publish(Bool(data=False))
        self.subscribe(JointState, "joint_states", self._hear, qos.NEWEST)
        self.senses = self._listen()
        self.serve(SetBool, "shoe/arm", self._arm)
        self._servers = [
            ActionServer(self, kind, name, do, cancel_callback=lambda _: CancelResponse.ACCEPT)
            for kind, name, do, offered in (
                (Plan, "shoe/plan", self._plan, True),
                (ReachSupport, REACH, self._reach, self.moving.steps),
            )
            if offered
        ]

    def _hear(self, messages: list[Any]) -> None:
        if (batch := self.joints.take(messages)) is not None:
            self.robot_time.note(int(batch.stamp_ns[-1]))

    def _listen(self) -> Senses:
        """To what is watched in addition to the joints, where it comes."""
        imu = ImuInput(self.robot, self.awake)
        temperatures = TemperatureInput(self.robot, self.awake)
        shoes = ShoeReports(lambda: states.get_publisher_count() > 0, self.awake)
        self.subscribe(Imu, "imu", imu.take, qos.EITHER)
        self.subscribe(Temperature, "joint_temperatures", temperatures.take, qos.EITHER)
        self.subscribe(DiagnosticArray, "diagnostics", temperatures.take_diagnostics, qos.EITHER)
        # A thousand a second must not keep the rest of the node from its work.
        self.realtime.subscribe(
            ShoeVoltages, "shoe/voltages", shoes.take_readings, qos.NEWEST, raw=True
        )
        states = self.subscribe(ShoeState, "shoe/state", shoes.take_states, qos.LATCHED)
        return Senses(imu, shoes, temperatures, self.kinematics, self.moving)

    def command(
        self, trajectory: JointTrajectory, stamp_ns: int = 0, not_after: float = math.inf
    ) -> bool:
        """Send a trajectory to the robot that begins at a stamp [ns]; zero: on receipt.

        Returns:
            Whether it was sent: not after a time by the monotonic clock [s].
        """
        message = trajectory_to_ros(trajectory, stamp_ns)
        # Asked last of all: a process may be stopped anywhere before.
        if time.monotonic() > not_after:
            return False
        self._command.publish(message)
        return True

    def watch(self) -> None:
        """Disarm what is not in use, and report the condition of joints and planning."""
        if self._busy:
            self.arming.use()
        self._commanders.look()
        if self.arming.armed and self._commanders.problem is not None:
            self.arming.set(False)
            self._armed.publish(Bool(data=False))
        # Repeated while it holds: so everybody knows soon when this node is gone.
        if self.arming.expire() or self.arming.armed:
            self._armed.publish(Bool(data=self.arming.armed))
        figures = self.joints.heard.figures()
        joints = Condition.of(self.joints.problem, "joint angles come", figures)
        self.health.note("joints", joints)
        self.health.report("arming", Level.OK, "armed" if self.arming.armed else "not armed")
        self.listeners.look()
        problem = self._commanders.problem
        commands = self.listeners.condition(armed=self.arming.armed)
        self.health.note("commands", commands if problem is None else Condition.of(problem, ""))
        self._report_planning()
        latest = self.joints.latest
        angles = None if latest is None else latest.angles[0]
        reported = watched(self.senses, angles)
        for subject, condition in reported.items():
            self.health.note(subject, condition)
        if self.moving.steps:
            self._report_steps()
        super().watch()

    def close(self) -> None:
        """Stop the robot, disarm, and end the worker."""
        self.arming.set(False)
        if self.context.ok():
            if self._execution is not None:
                self._execution.halt()
            self._armed.publish(Bool(data=False))
            for publisher in (self._command, self._armed):
                publisher.wait_for_all_acked(LAST_WORDS)
        self.worker.close()

    def _report_planning(self) -> None:
        well, error = "at work" if self._busy else "ready", self.worker.lost or self._prepared.error
        if not self._prepared.done:
            well = "preparing"
        problem = None if error is None else Problem.of(error)
        self.health.note("planning", Condition.of(problem, well))

    def _report_steps(self) -> None:
        """Whether this node alone offers to step: a goal reaches the one that answers first."""
        service = self.resolve_service_name(f"{REACH}/_action/send_goal")
        if self.count_services(service) > 1:
            self.health.report(
                "steps",
                Level.WARN,
                f"another node offers {REACH} too; let one of them do so (planner: steps, "
                "simulator: offer_reach_support)",
                Code.SECOND_STEPPER,
            )
        else:
            self.health.report("steps", Level.OK, f"this node offers {REACH}")

    def _arm(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        self._commanders.look()
        problem = self._commanders.problem if request.data else None
        self.arming.set(request.data and problem is None)
        self._armed.publish(Bool(data=self.arming.armed))
        response.success = problem is None
        if problem is not None:
            response.message = f"not armed: {problem}"
            return response
        response.message = (
            f"armed; disarms by itself after {self.moving.arm_timeout_s:g} s without use"
            if self.arming.armed
            else "disarmed; nothing moves"
        )
        return response

    async def _plan(self, goal: ServerGoalHandle) -> Plan.Result:
        result = Plan.Result()
        return await self._carry_out(goal, PlanJob(self, goal, result), result)

    async def _reach(self, goal: ServerGoalHandle) -> ReachSupport.Result:
        return await self._carry_out(goal, ReachJob(self, goal), ReachSupport.Result())

    async def _carry_out(self, goal: ServerGoalHandle, job: PlanJob | ReachJob, result: R) -> R:
        """One at a time; how it ended is in the result."""

        async def do() -> str:
            await self._refuse_in_another_job(goal.request.run_id, result.BUSY)
            if self._busy:
                raise RefusedError(result.BUSY, "another motion is under way; wait or cancel it")
            self._busy, self._execution = True, job.execution
            try:
                with (
                    self.working(job.name, goal.request.run_id),
                    faults_refused(self.log, result.FAILED),
                ):
                    await job.run()
            finally:
                self._busy = False
                job.execution.halt()
            return f"done; {heat.margin(self.senses.temperatures.degc, self.moving.hot_degc)}"

        return await answered(goal, result, do)

    async def _refuse_in_another_job(self, run_id: str, code: int) -> None:
        """While a job moves the robot, its own goals only: between two of them nothing is busy."""
        shoes = self.senses.shoes
        if not await until(lambda: shoes.job in {"", run_id}, STATE_S):
            reported = (
                f"job {short_name(shoes.job)} moves the robot; wait for it, cancel it or disarm"
            )
            raise RefusedError(code, reported)


def main() -> None:
    """Run the node."""
    run(PlannerNode)


if __name__ == "__main__":
    main()
